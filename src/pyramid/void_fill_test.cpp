// Data of several depths in one database: where they meet there is no step, and nothing that was measured moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geo/seed_test.h"
#include "pyramid/elevation_promises_test.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"
#include "raster/raster_file.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::kGutter;
using tiling::Scheme;
using tiling::TileId;

constexpr double kVoid = -9999.0;
constexpr int kSide = 96;  ///< pixels of a patch
constexpr double kPixel_degrees = 0.1;

/// Bumps of random places, heights and widths, no steeper than about 40 m a pixel, high above the hills of the globe.
struct Relief {
  explicit Relief(std::mt19937_64& random, double height_m = 1500.0) : above_m(height_m) {
    for (Wave& wave : waves) {
      wave = {geo::uniform(random, -1.5, 1.5), geo::uniform(random, -1.5, 1.5), geo::uniform(random, 0, 6.28)};
    }
  }
  double at(double lat, double lon) const {
    double height = hills(lat, lon) + above_m;
    for (const Wave& wave : waves)
      height += 20.0 * std::sin((wave.east * lon + wave.north * lat) * 6.28 + wave.phase);
    return height;
  }
  struct Wave {
    double east = 0.0, north = 0.0, phase = 0.0;
  };
  double above_m;
  std::array<Wave, 4> waves{};
};

/// Discs of all sizes, some over the border, and single pixels.
std::vector<bool> randomVoids(std::mt19937_64& random) {
  std::vector<bool> isVoid(static_cast<std::size_t>(kSide) * kSide, false);
  for (int i = 0; i < 12; ++i) {
    const double column = geo::uniform(random, 0, kSide);
    const double row = geo::uniform(random, 0, kSide);
    const double radius = std::exp(geo::uniform(random, -0.5, 2.7));
    for (int r = 0; r < kSide; ++r) {
      for (int c = 0; c < kSide; ++c) {
        if (std::hypot(c - column, r - row) < radius) isVoid[static_cast<std::size_t>(r * kSide + c)] = true;
      }
    }
  }
  return isVoid;
}

class VoidFillTest : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions options(const std::vector<std::string>& inputs, const std::string& name,
                       std::optional<double> fillVoids_m = {}) const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = inputs;
    options.scheme = GetParam();
    options.fillVoids_m = fillVoids_m;
    return options;
  }
  std::string globe() const {
    const std::filesystem::path path = folder_ / "globe.tif";
    writeElevation(path, degreesGrid(-180, -90, 180, 90, 360, 180),
                   [](int c, int r) { return std::round(hills(89.5 - r, -179.5 + c)); });
    return path.string();
  }
  std::string patch(const std::string& name, double west, double south, const Relief& relief,
                    const std::vector<bool>& isVoid) const {
    const double size = kSide * kPixel_degrees;
    GridSpec spec = degreesGrid(west, south, west + size, south + size, kSide, kSide);
    spec.type = SampleType::float32;
    spec.nodata = kVoid;
    const std::filesystem::path path = folder_ / name;
    writeElevation(path, spec, [&](int c, int r) {
      if (isVoid[static_cast<std::size_t>(r * kSide + c)]) return kVoid;
      return relief.at(south + size - (r + 0.5) * kPixel_degrees, west + (c + 0.5) * kPixel_degrees);
    });
    return path.string();
  }
  TemporaryFolder folder_;
  std::mt19937_64 random_ = geo::seededGenerator();
};

void expectSound(const std::filesystem::path& path) {
  const auto report = verifyPyramid(path);
  ASSERT_TRUE(report.has_value()) << io::describe(report.error());
  EXPECT_TRUE(report->sound()) << report->faults.front();
}

void expectAllPromises(const PyramidReader& reader) {
  expectSound(reader.info().name);
  expectEdgesShared(reader);
  expectDecimated(reader);
  expectErrorsBound(reader);
}

/// What rasters hold at the samples of a tile, later ones over earlier ones: bilinear in each as the builder reads it.
std::vector<float> measuredAt(const std::vector<std::string>& files, const tiling::Tiling& tiling, const TileId& id) {
  const int side = sideOf(raster::Kind::elevation, raster::kElevationCells);
  const auto places = openPlaces(tiling, id, raster::Kind::elevation, raster::kElevationCells,
                                 std::vector<bool>(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)));
  std::vector<float> heights(places.places.size(), raster::kNoData);
  for (const std::string& path : files) {
    auto file = raster::RasterFile::open(path, raster::Kind::elevation);
    EXPECT_TRUE(file.has_value());
    EXPECT_TRUE(
        file->sampleTile(tiling, id, raster::kElevationCells, places.indices, {}, std::span(heights)).has_value());
  }
  std::vector<float> all(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), raster::kNoData);
  for (std::size_t i = 0; i < heights.size(); ++i)
    all[places.indices[i]] = heights[i];
  return all;
}

/// The largest steps between samples next to each other on the deepest level: between two of which one is of a fine
/// raster, and between two that are.
struct Steps {
  double atRim_m = 0.0;
  double inData_m = 0.0;
  int rims = 0;
};

Steps stepsOf(const PyramidReader& reader, const std::vector<std::string>& fine) {
  const tiling::Tiling tiling(reader.info().scheme);
  Steps steps;
  for (const TileId& id : storedTiles(reader)) {
    if (id.level != reader.info().maxLevel) continue;
    const raster::SourceTile tile = loaded(reader, id);
    const raster::Raster<float>& heights = heightsOf(tile);
    const std::vector<float> measured = measuredAt(fine, tiling, id);
    const auto at = [&](int c, int r) { return static_cast<std::size_t>(r * heights.width + c); };
    for (int r = kGutter; r < heights.height - kGutter; ++r) {
      for (int c = kGutter; c < heights.width - kGutter; ++c) {
        const bool here = !raster::isNoData(measured[at(c, r)]);
        if (here) {
          EXPECT_EQ(heights.at(c, r), measured[at(c, r)]) << "real data moved";
        }
        for (const auto& [c2, r2] : {std::pair(c + 1, r), std::pair(c, r + 1)}) {
          if (c2 >= heights.width - kGutter || r2 >= heights.height - kGutter) continue;
          const bool there = !raster::isNoData(measured[at(c2, r2)]);
          const double step = std::abs(static_cast<double>(heights.at(c, r)) - static_cast<double>(heights.at(c2, r2)));
          EXPECT_FALSE(std::isnan(step));
          if (here && there) steps.inData_m = std::max(steps.inData_m, step);
          if (here == there) continue;
          steps.atRim_m = std::max(steps.atRim_m, step);
          ++steps.rims;
        }
      }
    }
  }
  return steps;
}

TEST_P(VoidFillTest, NoStepAtTheRimAndNoDataMoves) {
  const std::string below = globe();
  for (int i = 0; i < 2; ++i) {
    const Relief relief(random_);
    const std::string fine = patch("fine.tif", geo::uniform(random_, -180, 170), geo::uniform(random_, -88, 78), relief,
                                   randomVoids(random_));
    const auto filled = builtPyramid(options({below, fine}, "filled.tdb"));
    const auto asTheyWere = builtPyramid(options({below, fine}, "left.tdb", 0.0));
    ASSERT_TRUE(filled != nullptr && asTheyWere != nullptr);
    expectAllPromises(*filled);
    const Steps steps = stepsOf(*filled, {fine});
    const Steps left = stepsOf(*asTheyWere, {fine});
    ASSERT_GT(steps.rims, 100);
    EXPECT_GT(left.atRim_m, 1300.0);
    EXPECT_LT(steps.atRim_m, 2.0 * steps.inData_m) << "from " << left.atRim_m;
    std::filesystem::remove(folder_ / "filled.tdb");
    std::filesystem::remove(folder_ / "left.tdb");
  }
}

TEST_P(VoidFillTest, TheBytesDoNotDependOnTheNumberOfWorkers) {
  const std::vector<std::string> inputs{globe(), patch("fine.tif", 40, -5, Relief(random_), randomVoids(random_))};
  BuildOptions one = options(inputs, "one.tdb");
  one.jobs = 1;
  BuildOptions many = options(inputs, "many.tdb");
  many.jobs = 5;
  ASSERT_TRUE(builtPyramid(one) != nullptr && builtPyramid(many) != nullptr);
  EXPECT_EQ(bytesOf(one.output), bytesOf(many.output));
}

/// Finer data that is the coarse one shifted: a void as wide as a few samples of the coarse data must not show at all.
TEST_P(VoidFillTest, SmallVoidsVanish) {
  std::vector<bool> isVoid(static_cast<std::size_t>(kSide) * kSide, false);
  for (int r = 40; r < 48; ++r) {
    for (int c = 60; c < 68; ++c)
      isVoid[static_cast<std::size_t>(r * kSide + c)] = true;
  }
  const auto slope = [](double lat) { return 10.0 * lat; };
  const std::filesystem::path below = folder_ / "slope.tif";
  writeElevation(below, degreesGrid(-180, -90, 180, 90, 360, 180), [&](int, int r) { return slope(89.5 - r); });
  const auto fine = [&](const std::string& name, const auto& isHere) {
    GridSpec spec = degreesGrid(100, 20, 100 + kSide * kPixel_degrees, 20 + kSide * kPixel_degrees, kSide, kSide);
    spec.nodata = kVoid;
    writeElevation(folder_ / name, spec, [&](int c, int r) {
      const double lat = 20 + (kSide - r - 0.5) * kPixel_degrees;
      return isHere(c, r) ? slope(lat) + 1500.0 : kVoid;
    });
    return (folder_ / name).string();
  };
  const std::string whole = fine("whole.tif", [](int, int) { return true; });
  const std::string holed =
      fine("holed.tif", [&](int c, int r) { return !isVoid[static_cast<std::size_t>(r * kSide + c)]; });
  const auto filled = builtPyramid(options({below.string(), holed}, "filled.tdb"));
  ASSERT_NE(filled, nullptr);
  const tiling::Tiling tiling(GetParam());
  double worst_m = 0.0;
  int compared = 0;
  for (const TileId& id : storedTiles(*filled)) {
    if (id.level != filled->info().maxLevel) continue;
    const std::vector<float> truth = measuredAt({whole}, tiling, id);
    const raster::SourceTile tile = loaded(*filled, id);
    for (int r = kGutter; r < heightsOf(tile).height - kGutter; ++r) {
      for (int c = kGutter; c < heightsOf(tile).width - kGutter; ++c) {
        const float height = truth[static_cast<std::size_t>(r * heightsOf(tile).width + c)];
        if (raster::isNoData(height)) continue;
        worst_m =
            std::max(worst_m, std::abs(static_cast<double>(heightsOf(tile).at(c, r)) - static_cast<double>(height)));
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_LT(worst_m, 2.0) << "of 1500 m";
}

TEST_P(VoidFillTest, WithNothingCoarserVoidsStay) {
  const std::string fine = patch("fine.tif", 10, 10, Relief(random_), randomVoids(random_));
  const auto filled = builtPyramid(options({fine}, "filled.tdb"));
  const auto left = builtPyramid(options({fine}, "left.tdb", 0.0));
  ASSERT_TRUE(filled != nullptr && left != nullptr);
  const std::vector<TileId> tiles = storedTiles(*filled);
  ASSERT_EQ(tiles, storedTiles(*left));
  bool hasVoids = false;
  for (const TileId& id : tiles) {
    const raster::SourceTile a = loaded(*filled, id);
    const raster::SourceTile b = loaded(*left, id);
    for (std::size_t i = 0; i < heightsOf(a).samples.size(); ++i) {
      const float height = heightsOf(a).samples[i];
      ASSERT_TRUE(height == heightsOf(b).samples[i] || raster::isNoData(height));
      ASSERT_EQ(raster::isNoData(height), raster::isNoData(heightsOf(b).samples[i]));
      hasVoids |= raster::isNoData(height);
    }
  }
  EXPECT_TRUE(hasVoids);
}

/// Samples farther from the finer data than the limit are those of the coarse data alone.
TEST_P(VoidFillTest, NothingMovesBeyondTheLimit) {
  const std::string below = globe();
  const std::string fine =
      patch("fine.tif", 0, 0, Relief(random_), std::vector<bool>(static_cast<std::size_t>(kSide) * kSide, false));
  for (const double limit_m : {60e3, 400e3}) {
    const auto filled = builtPyramid(options({below, fine}, "filled.tdb", limit_m));
    ASSERT_NE(filled, nullptr);
    expectSound(folder_ / "filled.tdb");
    const tiling::Tiling tiling(GetParam());
    const double size = kSide * kPixel_degrees;
    int moved = 0;
    for (const TileId& id : storedTiles(*filled)) {
      const std::vector<float> coarse = measuredAt({below}, tiling, id);
      const raster::SourceTile tile = loaded(*filled, id);
      const int side = heightsOf(tile).width;
      for (int r = kGutter; r < side - kGutter; ++r) {
        for (int c = kGutter; c < side - kGutter; ++c) {
          const auto place = placeOf(tiling, id, raster::Kind::elevation, raster::kElevationCells, c, r);
          ASSERT_TRUE(place.has_value());
          const geo::Geodetic where = geo::geodeticFromDirection(*place);
          const geo::Direction nearest = geo::directionFromDegrees(std::clamp(where.lat.degrees(), 0.0, size),
                                                                   std::clamp(where.lon.degrees(), 0.0, size));
          const double away_m = geo::angleBetween(*place, nearest).radians() * 6.37e6;
          if (away_m == 0.0) continue;
          const bool isMoved = std::abs(static_cast<double>(heightsOf(tile).at(c, r)) -
                                        static_cast<double>(coarse[static_cast<std::size_t>(r * side + c)])) > 1.0;
          ASSERT_TRUE(!isMoved || away_m < 1.01 * limit_m) << away_m;
          moved += isMoved ? 1 : 0;
        }
      }
    }
    EXPECT_GT(moved, 10);
    std::filesystem::remove(folder_ / "filled.tdb");
  }
}

/// Of a patch beside one that was there before, voids meet both; and the base's data stays where it is.
TEST_P(VoidFillTest, WhatIsAppendedMeetsWhatIsThere) {
  const std::string below = globe();
  const Relief relief(random_);
  const std::string left = patch("left.tif", 40, -5, relief, randomVoids(random_));
  const std::string right = patch("right.tif", 40 + kSide * kPixel_degrees, -5, relief, randomVoids(random_));
  ASSERT_NE(builtPyramid(options({below, left}, "out.tdb")), nullptr);
  BuildOptions append = options({right}, "out.tdb");
  append.append = true;
  const auto reader = builtPyramid(append);
  ASSERT_NE(reader, nullptr);
  expectAllPromises(*reader);
  const Steps steps = stepsOf(*reader, {left, right});
  EXPECT_GT(steps.rims, 100);
  // What was filled before is coarse data now, and falls by the 1500 m within a few samples: a slope, no wall.
  EXPECT_LT(steps.atRim_m, 2.0 * steps.inData_m + 150.0);
  append.inputs = {left};
  append.fillVoids_m = 0.0;
  const auto refused = buildPyramid(append);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("--fill-voids"), std::string::npos) << refused.error().message;
}

/// Three depths at once, the coarsest data last in one place: the finer never moves, whatever the order.
TEST_P(VoidFillTest, ThreeDepthsInAnyOrder) {
  const std::string below = globe();
  const std::string fine = patch("fine.tif", 40, -5, Relief(random_), randomVoids(random_));
  GridSpec spec = degreesGrid(43, -3, 46, 0, 120, 120);
  spec.type = SampleType::float32;
  const std::filesystem::path finest = folder_ / "finest.tif";
  const Relief relief(random_, -500.0);
  writeElevation(finest, spec, [&](int c, int r) { return relief.at(-0.0125 - r * 0.025, 43.0125 + c * 0.025); });
  for (const std::vector<std::string>& inputs :
       {std::vector{below, fine, finest.string()}, std::vector{below, finest.string(), fine}}) {
    const auto reader = builtPyramid(options(inputs, "out.tdb"));
    ASSERT_NE(reader, nullptr);
    expectAllPromises(*reader);
    std::filesystem::remove(folder_ / "out.tdb");
  }
}

TEST(VoidFill, IsNothingThatImageryHas) {
  const TemporaryFolder folder;
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {"a.tif"};
  options.kind = raster::Kind::imagery;
  options.fillVoids_m = 10.0;
  const auto built = buildPyramid(options);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("--fill-voids"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Tilings, VoidFillTest, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
