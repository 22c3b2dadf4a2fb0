// Conversions beside the reference libraries, in one run on one thread: HEALPix pixel of a direction and back beside
// chealpix, geodetic to body frame and back beside GeographicLib.
//
// Each round times all sides one after the other, in processor time of this thread; the table has the medians over the
// rounds of the times and of the ratios, so that a machine that is busy for a while decides nothing.
#include <chealpix.h>

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "geo/body.h"
#include "tiling/healpix_pixels.h"

namespace {

using namespace tellurion;

constexpr std::size_t kPlaces = 20000;  // fits the second-level cache, as a batch of a program would
constexpr int kRounds = 41;
constexpr int kOrder = 20;

struct Side {
  std::string name;
  std::function<double()> run;  // over all places; a sum, so that nothing is left out
};

double processorNanoseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The first side is the reference.
void compare(const char* what, const std::vector<Side>& sides) {
  std::vector<std::vector<double>> ns(sides.size());
  std::vector<std::vector<double>> ratios(sides.size());
  double sum = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const double start = processorNanoseconds();
      sum += sides[i].run();
      ns[i].push_back((processorNanoseconds() - start) / static_cast<double>(kPlaces));
      ratios[i].push_back(ns[i].back() / ns[0].back());
    }
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    std::printf("%-28s %-22s %7.1f ns  %5.2f of the reference\n", what, sides[i].name.c_str(), median(ns[i]),
                median(ratios[i]));
  }
  if (sum == 0.125) std::puts("");
}

struct Places {
  std::vector<geo::Direction> directions;
  std::vector<std::int64_t> pixels;
  std::vector<geo::Geodetic> geodetic;
  std::vector<geo::BodyPosition> body;
};

Places randomPlaces() {
  std::mt19937_64 random(20261);
  std::uniform_real_distribution<double> sine(-1.0, 1.0);
  std::uniform_real_distribution<double> degrees(-180.0, 180.0);
  std::uniform_real_distribution<double> metres(-1e4, 4e5);
  Places places;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const geo::Geodetic g{.lat = geo::Angle::radians(std::asin(sine(random))),
                          .lon = geo::Angle::degrees(degrees(random)),
                          .height_m = metres(random)};
    places.geodetic.push_back(g);
    places.body.push_back(geo::earth().ellipsoid.bodyFromGeodetic(g));
    places.directions.push_back(geo::directionFromLatLon(g.lat, g.lon));
    std::int64_t pixel = 0;
    vec2pix_nest64(std::int64_t{1} << kOrder, &places.directions.back().n.x, &pixel);
    places.pixels.push_back(pixel);
  }
  return places;
}

void compareHealpix(const Places& places) {
  const std::int64_t side = std::int64_t{1} << kOrder;
  std::vector<std::uint64_t> pixels(kPlaces);
  std::vector<geo::Direction> directions(kPlaces);
  compare("HEALPix pixel of direction", {{"chealpix",
                                          [&] {
                                            std::int64_t pixel = 0;
                                            double sum = 0.0;
                                            for (const geo::Direction& d : places.directions) {
                                              vec2pix_nest64(side, &d.n.x, &pixel);
                                              sum += static_cast<double>(pixel);
                                            }
                                            return sum;
                                          }},
                                         {"one by one",
                                          [&] {
                                            double sum = 0.0;
                                            for (const geo::Direction& d : places.directions)
                                              sum += static_cast<double>(tiling::healpixNestedAt(d, kOrder));
                                            return sum;
                                          }},
                                         {"batch", [&] {
                                            tiling::healpixNestedAt(places.directions, kOrder, pixels);
                                            return static_cast<double>(pixels[kPlaces / 2]);
                                          }}});
  compare("direction of HEALPix pixel", {{"chealpix",
                                          [&] {
                                            double n[3];
                                            double sum = 0.0;
                                            for (const std::int64_t pixel : places.pixels) {
                                              pix2vec_nest64(side, pixel, n);
                                              sum += n[0];
                                            }
                                            return sum;
                                          }},
                                         {"one by one",
                                          [&] {
                                            double sum = 0.0;
                                            for (const std::int64_t pixel : places.pixels)
                                              sum +=
                                                  tiling::healpixCentre(static_cast<std::uint64_t>(pixel), kOrder).n.x;
                                            return sum;
                                          }},
                                         {"batch", [&] {
                                            for (std::size_t i = 0; i < kPlaces; ++i)
                                              pixels[i] = static_cast<std::uint64_t>(places.pixels[i]);
                                            tiling::healpixCentres(pixels, kOrder, directions);
                                            return directions[kPlaces / 2].n.x;
                                          }}});
}

void compareGeodetic(const Places& places) {
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  const GeographicLib::Geocentric reference(ellipsoid.semiMajorAxis_m(), ellipsoid.flattening());
  std::vector<GeographicLib::Math::real> degrees;
  for (const geo::Geodetic& g : places.geodetic) {
    degrees.push_back(g.lat.degrees());
    degrees.push_back(g.lon.degrees());
  }
  compare("body frame from geodetic", {{"GeographicLib",
                                        [&] {
                                          double sum = 0.0;
                                          for (std::size_t i = 0; i < kPlaces; ++i) {
                                            double x = 0.0;
                                            double y = 0.0;
                                            double z = 0.0;
                                            reference.Forward(degrees[2 * i], degrees[2 * i + 1],
                                                              places.geodetic[i].height_m, x, y, z);
                                            sum += x + y + z;
                                          }
                                          return sum;
                                        }},
                                       {"one by one", [&] {
                                          double sum = 0.0;
                                          for (const geo::Geodetic& g : places.geodetic) {
                                            const geo::Vec3 m = ellipsoid.bodyFromGeodetic(g).m;
                                            sum += m.x + m.y + m.z;
                                          }
                                          return sum;
                                        }}});
  compare("geodetic from body frame", {{"GeographicLib",
                                        [&] {
                                          double sum = 0.0;
                                          for (const geo::BodyPosition& p : places.body) {
                                            double lat = 0.0;
                                            double lon = 0.0;
                                            double height = 0.0;
                                            reference.Reverse(p.m.x, p.m.y, p.m.z, lat, lon, height);
                                            sum += lat + lon + height;
                                          }
                                          return sum;
                                        }},
                                       {"one by one", [&] {
                                          double sum = 0.0;
                                          for (const geo::BodyPosition& p : places.body) {
                                            const geo::Geodetic g = ellipsoid.geodeticFromBody(p);
                                            sum += g.lat.radians() + g.lon.radians() + g.height_m;
                                          }
                                          return sum;
                                        }}});
}

}  // namespace

int main() {
  const Places places = randomPlaces();
  std::printf("%zu random places, medians of %d rounds, processor time of one thread\n", kPlaces, kRounds);
  compareHealpix(places);
  compareGeodetic(places);
  return 0;
}
