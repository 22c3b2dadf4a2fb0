// The promises of elevation tiles, on every tile of small planets, for the three tilings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/elevation_promises_test.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::isNoData;
using raster::kGutter;
using tiling::Scheme;
using tiling::TileId;

constexpr int kCells = raster::kElevationCells;

class ElevationPyramid : public ::testing::TestWithParam<Scheme> {
 protected:
  BuildOptions options(const std::vector<std::string>& inputs, const std::string& name = "out.tdb") const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = inputs;
    options.scheme = GetParam();
    return options;
  }
  std::string globe() const { return writeHillyGlobe(folder_ / "globe.tif"); }
  /// Five times finer, a rough patch of some degrees across the equator, a third of it without data.
  std::string patch() const {
    GridSpec spec = degreesGrid(38, -4, 47, 5, 90, 90);
    spec.nodata = -9999;
    const std::filesystem::path path = folder_ / "patch.tif";
    writeElevation(path, spec, [](int c, int r) {
      return (c + 2 * r) % 90 < 30 && r > 20 ? -9999.0 : 500.0 + 300.0 * std::sin(0.9 * c) * std::cos(1.3 * r);
    });
    return path.string();
  }
  void expectSound(const std::filesystem::path& path) const {
    const auto report = verifyPyramid(path);
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    EXPECT_TRUE(report->sound()) << report->faults.front();
  }

  TemporaryFolder folder_;
};

double height(HeightQuery& query, double lat, double lon) {
  const auto answer = query.at(geo::directionFromDegrees(lat, lon));
  EXPECT_TRUE(answer.has_value());
  return answer && *answer ? (*answer)->height_m : std::numeric_limits<double>::quiet_NaN();
}

TEST_P(ElevationPyramid, GlobeKeepsEveryPromise) {
  const auto reader = builtPyramid(options({globe()}));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
}

TEST_P(ElevationPyramid, TheEarthKeepsEveryPromise) {
  const std::string source = TELLURION_SOURCE_DIR "/data/earth/etopo5_dem_10min.tif";
  const auto reader = builtPyramid(options({source}));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
  const Grid grid = readGrid(source);
  const tiling::Tiling tiling(GetParam());
  for (const TileId& id : storedTiles(*reader)) {
    if (id.level != reader->info().maxLevel) continue;
    const raster::SourceTile tile = loaded(*reader, id);
    for (int r = 0; r <= kCells; r += 16) {
      for (int c = 0; c <= kCells; c += 16) {
        const auto place = geo::geodeticFromDirection(tiling.direction(
            tiling::rootPointIn(id, static_cast<double>(c) / kCells, static_cast<double>(r) / kCells)));
        if (std::abs(place.lat.degrees()) > 89.9) continue;
        const double truth = grid.bilinear(place.lat.degrees(), place.lon.degrees());
        ASSERT_NEAR(static_cast<double>(heightsOf(tile).at(kGutter + c, kGutter + r)), truth, 1.0 / 32.0 + 1e-3);
      }
    }
  }
}

TEST_P(ElevationPyramid, InputsOfDifferentDepthKeepEveryPromise) {
  const auto reader = builtPyramid(options({globe(), patch()}));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
  // The globe alone stops earlier: it has tiles without any child above the deepest level.
  EXPECT_TRUE(std::ranges::any_of(storedTiles(*reader), [&](const TileId& id) {
    return id.level < reader->info().maxLevel && loaded(*reader, id).childMask == 0;
  }));
}

TEST_P(ElevationPyramid, CutDepthKeepsEveryPromise) {
  BuildOptions cut = options({globe(), patch()});
  cut.maxLevel = 2;
  const auto reader = builtPyramid(cut);
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(reader->info().maxLevel, 2);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  expectDecimated(*reader);
  expectErrorsBound(*reader);
}

TEST_P(ElevationPyramid, LevelZeroAloneIsABuild) {
  BuildOptions cut = options({globe()});
  cut.maxLevel = 0;
  const auto reader = builtPyramid(cut);
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(storedTiles(*reader).size(), static_cast<std::size_t>(tiling::Tiling(GetParam()).rootCount()));
  expectEdgesShared(*reader);
}

TEST_P(ElevationPyramid, QueryAgreesWithBilinearSamplingOfTheSource) {
  const std::string source = globe();
  const auto reader = builtPyramid(options({source}));
  ASSERT_NE(reader, nullptr);
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  const Grid grid = readGrid(source);
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> z(-1.0, 1.0);
  std::uniform_real_distribution<double> lon(-180.0, 180.0);
  double worst = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double lat = std::asin(z(random)) * 180.0 / geo::kPi;
    if (std::abs(lat) > 89.5) continue;  // beyond the last row the source continues across the pole
    const double east = lon(random);
    const auto answer = query->at(geo::directionFromDegrees(lat, east));
    ASSERT_TRUE(answer.has_value() && answer->has_value());
    worst = std::max(worst, std::abs((*answer)->height_m - grid.bilinear(lat, east)));
  }
  // Half a stored step is 1/32 m; the rest is the second bilinear interpolation, on a grid no coarser than the
  // source's: at most an eighth of the second difference over one cell, some 35 m here.
  EXPECT_LT(worst, 40.0);
  RecordProperty("worst_m", std::to_string(worst));
}

TEST_P(ElevationPyramid, HeightsAtTheTilesOwnSamplesAreTheSourcesToHalfAStep) {
  const std::string source = globe();
  const auto reader = builtPyramid(options({source}));
  ASSERT_NE(reader, nullptr);
  const Grid grid = readGrid(source);
  const tiling::Tiling tiling(GetParam());
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    for (int r = 0; r <= kCells; r += 4) {
      for (int c = 0; c <= kCells; c += 4) {
        const auto place = geo::geodeticFromDirection(tiling.direction(
            tiling::rootPointIn(id, static_cast<double>(c) / kCells, static_cast<double>(r) / kCells)));
        if (std::abs(place.lat.degrees()) > 89.5) continue;
        const double truth = grid.bilinear(place.lat.degrees(), place.lon.degrees());
        ASSERT_NEAR(static_cast<double>(heightsOf(tile).at(kGutter + c, kGutter + r)), truth, 1.0 / 32.0 + 1e-3);
      }
    }
  }
}

TEST_P(ElevationPyramid, NoDataStaysNoData) {
  const auto reader = builtPyramid(options({patch()}));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  const auto heightAt = [&](double lat, double lon) { return height(*query, lat, lon); };
  EXPECT_FALSE(std::isnan(heightAt(4.95, 38.05)));
  EXPECT_TRUE(std::isnan(heightAt(20.0, 42.0)));                           // outside
  EXPECT_TRUE(std::isnan(heightAt(-90.0, 0.0)));                           // far outside
  EXPECT_TRUE(std::isnan(heightAt(5.0 - 35.5 * 0.1, 38.0 + 27.5 * 0.1)));  // (27 + 70) % 90 = 7: void
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    for (const float height : heightsOf(tile).samples) {
      ASSERT_TRUE(isNoData(height) || (height >= 199.0f && height <= 801.0f)) << height;
    }
  }
}

TEST_P(ElevationPyramid, OnlyTilesWithDataAreStored) {
  const auto reader = builtPyramid(options({patch()}));
  ASSERT_NE(reader, nullptr);
  const double area = 9.0 * 9.0 * std::pow(geo::kPi / 180.0, 2);
  const tiling::Tiling tiling(GetParam());
  std::size_t deepest = 0;
  double deepestArea = 0.0;
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    EXPECT_TRUE(tile.childMask != 0 || !isNoData(tile.statistics.min_m));
    if (id.level != reader->info().maxLevel) continue;
    ++deepest;
    deepestArea += tiling.area(id);
  }
  EXPECT_GE(deepest, 1U);
  EXPECT_LT(deepestArea, 9.0 * area);
}

TEST_P(ElevationPyramid, DateLineAndPoles) {
  GridSpec crossing = degreesGrid(175, -10, 187, 10, 60, 100);
  writeElevation(folder_ / "crossing.tif", crossing, [](int c, int r) { return 10.0 * c + r; });
  GridSpec pole;
  pole.width = 100;
  pole.height = 100;
  pole.geotransform = {-500000, 10000, 0, 500000, 0, -10000};
  pole.reference = "EPSG:3031";
  pole.type = SampleType::float32;
  writeElevation(folder_ / "pole.tif", pole, [](int c, int r) { return 3000.0 - std::hypot(c - 49.5, r - 49.5); });
  const auto reader = builtPyramid(options({(folder_ / "crossing.tif").string(), (folder_ / "pole.tif").string()}));
  ASSERT_NE(reader, nullptr);
  expectSound(folder_ / "out.tdb");
  expectEdgesShared(*reader);
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  const auto heightAt = [&](double lat, double lon) { return height(*query, lat, lon); };
  EXPECT_NEAR(heightAt(-90.0, 0.0), 2999.3, 0.7);
  EXPECT_NEAR(heightAt(-89.0, 77.0), 3000.0 - 11.1, 0.7);
  EXPECT_TRUE(std::isnan(heightAt(-80.0, 77.0)));
  // Column 25 is longitude 180: its pixel spans 180 to 180.2.
  EXPECT_NEAR(heightAt(0.1, -179.9), 250.0 + 49.0, 0.6);
  EXPECT_NEAR(heightAt(0.1, 180.0), 245.0 + 49.0, 0.6);
  EXPECT_NEAR(heightAt(0.1, 179.9), 240.0 + 49.0, 0.6);
  EXPECT_TRUE(std::isnan(heightAt(0.1, -172.0)));
}

TEST_P(ElevationPyramid, FloatHeightsAreKeptExactly) {
  GridSpec spec = degreesGrid(-180, -90, 180, 90, 72, 36);
  spec.type = SampleType::float32;
  writeElevation(folder_ / "flat.tif", spec, [](int, int) { return 123.456; });
  const auto reader = builtPyramid(options({(folder_ / "flat.tif").string()}));
  ASSERT_NE(reader, nullptr);
  const auto summary = reader->summary();
  ASSERT_TRUE(summary.has_value());
  EXPECT_EQ(summary->heightStep_m, 0.0);
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    EXPECT_EQ(tile.statistics.min_m, 123.456f);
    EXPECT_EQ(tile.statistics.max_m, 123.456f);
    EXPECT_EQ(tile.statistics.error_m, 0.0f);
  }
}

INSTANTIATE_TEST_SUITE_P(Tilings, ElevationPyramid,
                         ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
