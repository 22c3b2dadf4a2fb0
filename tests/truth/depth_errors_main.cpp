// How far the surface in a picture is off from a raster, whoever drew it: reads what a program drew at some pixels,
// casts rays through the raster bilinear between its samples, and prints what the pixels are off (truth/pixel_miss.h).
//
//   depth_errors RASTER.tif|DATABASE.tdb LAT,LON,HEIGHT,HEADING,PITCH,ROLL WIDTHxHEIGHT FOV < drawn
//
// Heights above WGS 84; FOV is vertical, in degrees. Of a tile database the surface is that of its finest level.
// `drawn` is lines of 'COL ROW METRES': a pixel, 0 0 at the top left, and how far along the ray through its centre the
// surface is drawn, nan for sky. Prints a JSON object; sky that is sky is not counted. Bad use or input: exit status 2.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "geo/body.h"
#include "pyramid/pyramid_reader.h"
#include "truth/finest_surface.h"
#include "truth/pixel_miss.h"
#include "truth/ray_caster.h"

namespace tellurion::truth {
namespace {

constexpr double kMost_px = 64.0;  ///< further the surface is not looked for

struct Drawn {
  int col = 0;
  int row = 0;
  double distance_m = 0.0;
};

double numberIn(const std::string& text, const char* what) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    throw std::runtime_error(fmt::format("{}: '{}' is no number", what, text));
  return value;
}

scene::Viewport viewportIn(const std::string& text) {
  const std::size_t x = text.find('x');
  const double width = numberIn(text.substr(0, x), "the picture's width");
  const double height = numberIn(x == std::string::npos ? "" : text.substr(x + 1), "the picture's height");
  if (!(width >= 1 && width <= 65536 && height >= 1 && height <= 65536))
    throw std::runtime_error("the picture's size is not within 1x1 to 65536x65536");
  return {.width = static_cast<int>(width), .height = static_cast<int>(height)};
}

std::vector<Drawn> readDrawn(std::istream& in, scene::Viewport size) {
  std::vector<Drawn> all;
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    Drawn drawn;
    std::string distance;
    if (!(fields >> drawn.col >> drawn.row >> distance) || drawn.col < 0 || drawn.col >= size.width || drawn.row < 0 ||
        drawn.row >= size.height)
      throw std::runtime_error(fmt::format("line {}: '{}' is no pixel of the picture", all.size() + 1, line));
    drawn.distance_m = numberIn(distance, "a distance");
    all.push_back(drawn);
  }
  if (all.empty()) throw std::runtime_error("nothing is drawn: no lines of 'COL ROW METRES' came in");
  return all;
}

SeenAlong surfaceOf(const std::string& path, double pixelAngle) {
  if (!path.ends_with(".tdb")) {
    const auto raster = std::make_shared<SourceSurface>(std::vector{path}, geo::earth().ellipsoid);
    return [=](const geo::Ray& ray) { return exactly(distanceFinelyAlong(*raster, ray, pixelAngle)); };
  }
  const auto database = pyramid::PyramidReader::open(path);
  if (!database) throw std::runtime_error(io::describe(database.error()));
  const auto finest = std::make_shared<FinestSurface>(**database);
  return [=](const geo::Ray& ray) { return exactly(finest->distanceAlong(ray)); };
}

/// What each pixel is off, in pixels; negative where there is sky in the picture and in truth.
std::vector<double> missesOf(const std::vector<Drawn>& drawn, const SeenAlong& surface, const scene::View& view) {
  std::vector<double> misses(drawn.size());
  const auto some = [&](std::size_t first) {
    for (std::size_t i = first; i < drawn.size(); i += 2) {
      const scene::PixelPosition pixel{drawn[i].col + 0.5, drawn[i].row + 0.5};
      const Seen centre = surface(scene::rayThrough(view, pixel));
      const bool isSky = std::isnan(drawn[i].distance_m) && std::isnan(centre.nearest_m);
      misses[i] = isSky ? -1.0 : missOf(surface, view, pixel, drawn[i].distance_m, centre, kMost_px);
    }
  };
  {
    const std::jthread other(some, 1);
    some(0);
  }
  return misses;
}

void print(const std::vector<Drawn>& drawn, std::vector<double> misses) {
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(misses) - misses.begin());
  const Drawn at = drawn[worst];
  std::ranges::sort(misses);
  misses.erase(misses.begin(), std::ranges::lower_bound(misses, 0.0));
  if (misses.empty()) throw std::runtime_error("there is nothing but sky, in the picture and in truth");
  const auto within = [&](double px) {
    const auto n = std::ranges::upper_bound(misses, px) - misses.begin();
    return static_cast<double>(n) / static_cast<double>(misses.size());
  };
  const auto percentile = [&](double share) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(misses.size())));
    return std::min(misses[std::max<std::size_t>(rank, 1) - 1], kMost_px);  // JSON has no infinity
  };
  fmt::print(
      "{{\"pixels\": {}, \"median_px\": {:.3f}, \"p90_px\": {:.3f}, \"p99_px\": {:.3f}, \"worst_px\": {:.3f}, "
      "\"within_1_px\": {:.4f}, \"looked_px\": {:g}, \"worst_at\": [{}, {}]}}\n",
      misses.size(), percentile(0.5), percentile(0.9), percentile(0.99), percentile(1.0), within(1.0), kMost_px, at.col,
      at.row);
}

void run(const std::vector<std::string>& arguments) {
  if (arguments.size() != 4)
    throw std::runtime_error(
        "usage: depth_errors RASTER|DATABASE.tdb LAT,LON,HEIGHT,HEADING,PITCH,ROLL WIDTHxHEIGHT FOV");
  const auto camera = scene::parseCamera(arguments[1]);
  if (!camera) throw std::runtime_error(io::describe(camera.error()));
  const scene::View view =
      scene::viewOf(*camera, geo::earth().ellipsoid, geo::Angle::degrees(numberIn(arguments[3], "the field of view")),
                    viewportIn(arguments[2]));
  const std::vector<Drawn> drawn = readDrawn(std::cin, view.viewport);
  print(drawn, missesOf(drawn, surfaceOf(arguments[0], view.pixelAngle()), view));
}

}  // namespace
}  // namespace tellurion::truth

int main(int argc, char** argv) {
  try {
    tellurion::truth::run({argv + 1, argv + argc});
  } catch (const std::exception& failure) {
    fmt::print(stderr, "depth_errors: {}\n", failure.what());
    return 2;
  }
}
