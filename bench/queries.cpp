// Heights of random places out of a tile database, beside GDAL's 2 x 2 reads of the same raster in a compressed file
// and beside a flat array of it in memory, in one run on one thread. bench/queries.sh makes the two files.
//
//   query_speed DATABASE RASTER [CACHE_MIB]
//
// Places are uniform over the sphere and no two rounds ask the same. Each round times all sides one after the other, in
// processor time of this thread, which reading files is part of.
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "pyramid/height_query.h"
#include "pyramid/pyramid_reader.h"

namespace {

using namespace tellurion;

constexpr int kRounds = 7;

double processorSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct LatLon {
  double lat;
  double lon;
};

std::vector<LatLon> randomPlaces(std::mt19937_64& random, std::size_t count) {
  std::uniform_real_distribution<double> sine(-1.0, 1.0);
  std::uniform_real_distribution<double> degrees(-180.0, 180.0);
  std::vector<LatLon> places(count);
  for (LatLon& p : places)
    p = {std::asin(sine(random)) * 180.0 / geo::kPi, degrees(random)};
  return places;
}

struct Side {
  std::string name;
  std::size_t places;  // a round
  std::function<double(const std::vector<LatLon>&)> run;
};

/// Ratios are to the first side.
void compare(const char* what, const std::vector<Side>& sides) {
  std::mt19937_64 random(20261);
  std::vector<std::vector<double>> rate(sides.size());
  std::vector<std::vector<double>> ratio(sides.size());
  double sum = 0.0;
  for (int round = 0; round <= kRounds; ++round) {  // the first one warms the caches
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const std::vector<LatLon> places = randomPlaces(random, sides[i].places);
      const double start = processorSeconds();
      sum += sides[i].run(places);
      const double perSecond = static_cast<double>(places.size()) / (processorSeconds() - start);
      if (round == 0) continue;
      rate[i].push_back(perSecond);
      ratio[i].push_back(perSecond / rate[0].back());
    }
  }
  std::printf("%s\n", what);
  for (std::size_t i = 0; i < sides.size(); ++i)
    std::printf("  %-46s %12.0f a second, %7.2f times the first\n", sides[i].name.c_str(), median(rate[i]),
                median(ratio[i]));
  if (sum == 0.125) std::puts("");
}

/// The raster whole in memory.
struct FlatArray {
  int width = 0;
  int height = 0;
  std::vector<std::int16_t> values;

  double at(const LatLon& p) const {
    const double column = (p.lon + 180.0) / 360.0 * width - 0.5;
    const double row = (90.0 - p.lat) / 180.0 * height - 0.5;
    const int c = std::clamp(static_cast<int>(column), 0, width - 2);
    const int r = std::clamp(static_cast<int>(row), 0, height - 2);
    const std::int16_t* top =
        &values[static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
    const std::int16_t* bottom = top + width;
    const double s = column - c;
    const double t = row - r;
    return (top[0] * (1 - s) + top[1] * s) * (1 - t) + (bottom[0] * (1 - s) + bottom[1] * s) * t;
  }
};

FlatArray readWhole(GDALDataset& raster) {
  FlatArray flat{.width = raster.GetRasterXSize(), .height = raster.GetRasterYSize(), .values = {}};
  flat.values.resize(static_cast<std::size_t>(flat.width) * static_cast<std::size_t>(flat.height));
  if (raster.GetRasterBand(1)->RasterIO(GF_Read, 0, 0, flat.width, flat.height, flat.values.data(), flat.width,
                                        flat.height, GDT_Int16, 0, 0, nullptr) != CE_None)
    std::exit(1);
  return flat;
}

double readTwoByTwo(GDALRasterBand& band, const LatLon& p) {
  const int width = band.GetXSize();
  const int height = band.GetYSize();
  const double column = (p.lon + 180.0) / 360.0 * width - 0.5;
  const double row = (90.0 - p.lat) / 180.0 * height - 0.5;
  const int c = std::clamp(static_cast<int>(column), 0, width - 2);
  const int r = std::clamp(static_cast<int>(row), 0, height - 2);
  std::array<double, 4> v{};
  if (band.RasterIO(GF_Read, c, r, 2, 2, v.data(), 2, 2, GDT_Float64, 0, 0, nullptr) != CE_None) std::exit(1);
  const double s = column - c;
  const double t = row - r;
  return (v[0] * (1 - s) + v[1] * s) * (1 - t) + (v[2] * (1 - s) + v[3] * s) * t;
}

double oneByOne(const pyramid::HeightQuery& query, const std::vector<LatLon>& places) {
  double sum = 0.0;
  for (const LatLon& p : places)
    sum += query.at(geo::directionFromDegrees(p.lat, p.lon)).value()->height_m;
  return sum;
}

double inBatches(const pyramid::HeightQuery& query, const std::vector<LatLon>& places, std::size_t batch) {
  std::vector<geo::Direction> directions(batch);
  std::vector<std::optional<pyramid::HeightAnswer>> answers(batch);
  double sum = 0.0;
  for (std::size_t start = 0; start < places.size(); start += batch) {
    for (std::size_t i = 0; i < batch; ++i)
      directions[i] = geo::directionFromDegrees(places[start + i].lat, places[start + i].lon);
    if (!query.at(directions, answers)) std::exit(1);
    for (const auto& answer : answers)
      sum += answer->height_m;
  }
  return sum;
}

int complain(const std::string& what) {
  std::fprintf(stderr, "query_speed: %s\n", what.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: query_speed DATABASE RASTER [CACHE_MIB]\n");
    return 2;
  }
  const std::uint64_t cacheBytes = (argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 64) << 20u;
  GDALAllRegister();
  GDALSetCacheMax64(static_cast<GIntBig>(cacheBytes));
  auto* raster = GDALDataset::Open(argv[2], GDAL_OF_RASTER);
  const auto database = pyramid::PyramidReader::open(argv[1]);
  if (!database) return complain(io::describe(database.error()));
  if (raster == nullptr) return complain(std::string(argv[2]) + ": no raster that GDAL opens");
  const auto small = pyramid::HeightQuery::create(*database, cacheBytes);
  const auto large = pyramid::HeightQuery::create(*database, std::uint64_t{4} << 30u);
  if (!small || !large) return complain("holds no elevation");
  GDALRasterBand& band = *raster->GetRasterBand(1);

  constexpr std::size_t kMany = std::size_t{1} << 20u;
  const std::string kept =
      std::to_string(cacheBytes >> 20u) + " MiB are kept of " +
      std::to_string((static_cast<std::uint64_t>(band.GetXSize()) * static_cast<std::uint64_t>(band.GetYSize()) * 2) >>
                     20u) +
      " MiB of samples";
  compare(kept.c_str(),
          {{"GDAL, 2 x 2 reads", 5000,
            [&](const auto& places) {
              double sum = 0.0;
              for (const LatLon& p : places)
                sum += readTwoByTwo(band, p);
              return sum;
            }},
           {"one by one", 10000, [&](const auto& places) { return oneByOne(*small, places); }},
           {"batches of 131072", kMany / 8, [&](const auto& places) { return inBatches(*small, places, kMany / 8); }},
           {"batches of 1048576", kMany, [&](const auto& places) { return inBatches(*small, places, kMany); }}});

  const FlatArray flat = readWhole(*raster);
  std::mt19937_64 random(1);
  inBatches(*large, randomPlaces(random, kMany), kMany);  // brings all tiles
  compare("all in memory",
          {{"flat array of 16 bits, bilinear", kMany,
            [&](const auto& places) {
              double sum = 0.0;
              for (const LatLon& p : places)
                sum += flat.at(p);
              return sum;
            }},
           {"one by one", kMany, [&](const auto& places) { return oneByOne(*large, places); }},
           {"batches of 1024", kMany, [&](const auto& places) { return inBatches(*large, places, 1024); }},
           {"batches of 65536", kMany, [&](const auto& places) { return inBatches(*large, places, 65536); }},
           {"batches of 1048576", kMany, [&](const auto& places) { return inBatches(*large, places, kMany); }}});
  GDALClose(raster);
  return 0;
}
