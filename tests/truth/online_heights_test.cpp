#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <semaphore>
#include <string>
#include <vector>

#include "geo/seed_test.h"
#include "raster/tile_places.h"
#include "scene/layer_sources.h"
#include "scene/scene_file.h"
#include "truth/proof_options.h"

// Samples of heights that came from servers against the local raster that the servers stand on, whose pixels are those
// of their images. Everywhere, at each spacing of samples, against that raster's pixels out of files: the places, the
// rules and the lattice are the same, and what differs is what protocol and encoding do. And where neither side
// averages, against the raster drawn live, which shares none of that way. (Where they do, they differ by choice:
// squares of the one are a tenth wider, and near the poles its pixels, narrow there, are averaged on the finest level
// too.) tests/online_heights_test.py starts the servers and this program.
namespace tellurion::truth {

const std::vector<std::string> kOptionNames{"scene", "steps", "random"};

namespace {

using Source = std::shared_ptr<const raster::TileSource>;

/// Heights from 4096 m on as floats: 0.0005 m a step, and either side rounds once or twice.
constexpr double kRounding_m = 0.001;
constexpr int kCoarsest = 2;  ///< means over 4 x 4 pixels
constexpr int kFinest = 4;    ///< between pixels, about as far apart

struct Place {
  const char* name;
  double latitude_degrees;
  double longitude_degrees;
};
constexpr Place kPlaces[] = {
    {"north pole", 90.0, 0.0},        {"south pole", -90.0, 0.0},    {"beside the north pole", 88.9, 77.0},
    {"date line", 0.1, 179.99},       {"date line", -17.0, -179.99}, {"date line, Chukotka", 66.0, 180.0},
    {"Greenwich, equator", 0.0, 0.0}, {"Everest", 27.99, 86.93},     {"Mariana Trench", 11.37, 142.59}};

/// Largest difference of samples that both have, how many those are, and how many only one side has.
struct Miss {
  double largest_m = 0.0;
  std::size_t compared = 0;
  std::size_t oneSided = 0;
  tiling::TileId worst;
};

std::vector<Source> openedOf(const std::string& file, tiling::Scheme scheme) {
  const std::vector<std::string> settings{"tiling=" + std::string(tiling::nameOf(scheme))};
  const auto scene = scene::openScene(file, settings);
  EXPECT_TRUE(scene) << io::describe(scene.error());
  if (!scene) return {};
  auto layers = scene::openLayers(*scene, {});
  EXPECT_TRUE(layers) << io::describe(layers.error());
  if (!layers) return {};
  std::vector<Source> sources;
  for (scene::LayerSource& layer : layers->elevation) {
    if (!layer.open) {
      auto opened = layer.opening();
      EXPECT_TRUE(opened) << layer.name << ": " << io::describe(opened.error());
      if (!opened) return {};
      layer.open = *opened;
    }
    sources.push_back(layer.open);
  }
  return sources;
}

std::vector<tiling::TileId> tilesOf(const tiling::Tiling& tiling) {
  std::vector<tiling::TileId> tiles;
  auto random = geo::seededGenerator();
  for (int level = kCoarsest; level <= kFinest; ++level) {
    for (const Place& place : kPlaces)
      tiles.push_back(tiling.tileAt(geo::directionFromDegrees(place.latitude_degrees, place.longitude_degrees), level));
    for (int i = 0; i < option("random", 1); ++i)
      tiles.push_back(
          tiling.tileAt(geo::directionFromDegrees(std::asin(geo::uniform(random, -1.0, 1.0)) * 180.0 / geo::kPi,
                                                  geo::uniform(random, -180.0, 180.0)),
                        level));
  }
  const auto key = [](const tiling::TileId& t) { return std::tuple(t.level, t.root, t.x, t.y); };
  std::ranges::sort(tiles, {}, key);
  const auto same = std::ranges::unique(tiles);
  tiles.erase(same.begin(), same.end());
  return tiles;
}

std::string nameOf(const tiling::TileId& id) {
  return "tile " + std::to_string(id.level) + "/" + std::to_string(id.root) + "/" + std::to_string(id.x) + "/" +
         std::to_string(id.y);
}

bool isCorner(int column, int row, int side) {
  return (column == 0 || column == side - 1) && (row == 0 || row == side - 1);
}

/// At samples of which `counts` is set.
void compare(const raster::Raster<float>& local, const raster::Raster<float>& served, const std::vector<bool>& counts,
             const tiling::TileId& id, Miss& miss) {
  ASSERT_EQ(local.width, served.width);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (!counts[i]) continue;
    const double a = static_cast<double>(local.samples[i]);
    const double b = static_cast<double>(served.samples[i]);
    if (std::isnan(a) != std::isnan(b)) ++miss.oneSided;
    if (std::isnan(a) || std::isnan(b)) continue;
    ++miss.compared;
    const double off_m = std::abs(a - b);
    if (off_m <= miss.largest_m) continue;
    miss.largest_m = off_m;
    miss.worst = id;
  }
}

/// All but corners that no single place owns, and those that lie further from the equator.
std::vector<bool> samplesUpTo(double latitude_degrees, const tiling::Tiling& tiling, const tiling::TileId& id) {
  const double highest = std::sin(latitude_degrees * geo::kPi / 180.0);
  const int side = raster::sideOf(raster::Kind::elevation, raster::kElevationCells);
  std::vector<bool> counts;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const auto place = raster::placeOf(tiling, id, raster::Kind::elevation, raster::kElevationCells, column, row);
      counts.push_back(!isCorner(column, row, side) && place && std::abs(place->n.z) <= highest);
    }
  }
  return counts;
}

std::optional<raster::Raster<float>> samplesOf(const raster::TileSource& source, const tiling::TileId& id) {
  // Prepared, since a load that was not gives up after a minute, which servers on a busy machine may take.
  constexpr std::chrono::minutes kPatience(5);
  std::binary_semaphore isReady(0);
  const auto preparation = source.prepare(id, 1.0, [&] { isReady.release(); });
  const bool isLate = preparation && !isReady.try_acquire_for(kPatience);
  EXPECT_FALSE(isLate) << source.info().name << ", " << nameOf(id);
  auto tile = source.load(id);
  EXPECT_TRUE(tile) << source.info().name << ", " << nameOf(id) << ": " << io::describe(tile.error());
  if (!tile || !*tile) return std::nullopt;
  return std::get<raster::ElevationTile>((*tile)->payload).samples;
}

void expectWithin(const char* what, double step_m, const Source& source, const Miss& miss) {
  const std::string& name = source->info().name;
  std::printf("%s, %s, against %s: at most %.4f m off in %zu samples, a step is %.4f m; worst in %s\n",
              std::string(tiling::nameOf(source->info().scheme)).c_str(), name.c_str(), what, miss.largest_m,
              miss.compared, step_m, nameOf(miss.worst).c_str());
  EXPECT_LE(miss.largest_m, 0.5 * step_m + kRounding_m) << name << " against " << what;
  EXPECT_EQ(miss.oneSided, 0u) << name << " against " << what;
  EXPECT_GT(miss.compared, 10000u) << name << " against " << what;
}

class OnlineHeights : public testing::TestWithParam<tiling::Scheme> {};

TEST_P(OnlineHeights, samplesAreWithinHalfAStepOfTheRasters) {
  constexpr double kNoneAverages_degrees = 35.0;  // where a sample is as wide as 1.25 pixels of a parallel
  const std::string file = option("scene", std::string());
  if (file.empty()) GTEST_SKIP() << "needs servers: run tests/online_heights_test.py";
  const std::vector<double> steps_m = option("steps", std::vector<double>{});
  const std::vector<Source> sources = openedOf(file, GetParam());
  ASSERT_EQ(sources.size(), steps_m.size() + 2) << "the live raster, its pixels, and a layer for each step";
  std::vector<Miss> ofLive(sources.size());
  std::vector<Miss> ofPixels(sources.size());
  const tiling::Tiling tiling(GetParam());
  for (const tiling::TileId& id : tilesOf(tiling)) {
    const auto live = samplesOf(*sources[0], id);
    const auto pixels = samplesOf(*sources[1], id);
    ASSERT_TRUE(live && pixels) << nameOf(id);
    const std::vector<bool> all = samplesUpTo(90.0, tiling, id);
    const std::vector<bool> some =
        id.level == kFinest ? samplesUpTo(kNoneAverages_degrees, tiling, id) : std::vector<bool>();
    compare(*live, *pixels, some, id, ofLive[1]);
    for (std::size_t i = 2; i < sources.size(); ++i) {
      const auto served = samplesOf(*sources[i], id);
      ASSERT_TRUE(served) << sources[i]->info().name << ", " << nameOf(id);
      compare(*pixels, *served, all, id, ofPixels[i]);
      compare(*live, *served, some, id, ofLive[i]);
    }
  }
  expectWithin("the live raster", 0.0, sources[1], ofLive[1]);
  for (std::size_t i = 2; i < sources.size(); ++i) {
    expectWithin("the raster's pixels", steps_m[i - 2], sources[i], ofPixels[i]);
    expectWithin("the live raster", steps_m[i - 2], sources[i], ofLive[i]);
  }
}

INSTANTIATE_TEST_SUITE_P(Tilings, OnlineHeights,
                         testing::Values(tiling::Scheme::cube, tiling::Scheme::geographic, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::truth
