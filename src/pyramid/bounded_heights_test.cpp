// Heights that may be off by a bound: against the sources themselves, read by GDAL and interpolated here.
#include "pyramid/bounded_heights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/elevation_promises_test.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::isNoData;
using raster::Kind;
using tiling::Scheme;
using tiling::TileId;

constexpr int kCells = raster::kElevationCells;
constexpr int kSide = kCells + 1 + 2 * raster::kGutter;

/// A source without voids, and what it is built with.
struct Case {
  const char* path;  ///< below the shared data
  Scheme scheme;
  double maxError_m;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.path << " " << tiling::nameOf(c.scheme) << " " << c.maxError_m;
}

std::uint64_t payloadBytes(const PyramidReader& reader) {
  std::uint64_t bytes = 0;
  const auto summary = reader.summary();
  EXPECT_TRUE(summary.has_value());
  if (!summary) return 0;
  for (const LevelSummary& level : summary->levels)
    bytes += level.payloadBytes;
  return bytes;
}

class BoundedHeights : public ::testing::TestWithParam<Case> {
 protected:
  std::filesystem::path source() const { return std::filesystem::path(TELLURION_SHARED_DATA_DIR) / GetParam().path; }
  BuildOptions options(std::optional<double> maxError_m, const std::string& name) const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {source().string()};
    options.scheme = GetParam().scheme;
    options.maxError_m = maxError_m;
    return options;
  }
  /// Whether the builder interpolates as Grid does: not in the outer half pixels.
  static bool isPlain(const Grid& grid, const geo::Geodetic& place) {
    const auto& t = grid.geotransform;
    const double column = (place.lon.degrees() - t[0]) / t[1];
    const double row = (place.lat.degrees() - t[3]) / t[5];
    const bool goesAround = std::abs(grid.width * t[1]) > 359.0;
    return row > 0.5 && row < grid.height - 0.5 && (goesAround || (column > 0.5 && column < grid.width - 0.5));
  }

  TemporaryFolder folder_;
};

struct Worst {
  double distance_m = 0.0;
  int samples = 0;
};

TEST_P(BoundedHeights, NoStoredHeightIsOffByMoreAndFilesAreMuchSmaller) {
  if (!std::filesystem::exists(source())) GTEST_SKIP() << source() << " is not there";
  const auto reader = builtPyramid(options(GetParam().maxError_m, "bounded.tdb"));
  ASSERT_NE(reader, nullptr);
  const Grid grid = readGrid(source());
  const tiling::Tiling tiling(GetParam().scheme);
  constexpr std::size_t kStride = 7;  // coprime with the side of 67: it comes by every column
  Worst worst;
  for (const TileId& id : storedTiles(*reader)) {
    const raster::SourceTile tile = loaded(*reader, id);
    if (tile.childMask == 15) continue;  // its samples are its children's
    const auto open = raster::openPlaces(tiling, id, Kind::elevation, kCells, std::vector<bool>(kSide * kSide, false));
    for (std::size_t i = 0; i < open.indices.size(); i += kStride) {
      const float stored = heightsOf(tile).samples[open.indices[i]];
      const geo::Geodetic place = geo::geodeticFromDirection(open.places[i]);
      if (isNoData(stored) || !isPlain(grid, place)) continue;
      const double truth = grid.bilinear(place.lat.degrees(), place.lon.degrees());
      worst.distance_m = std::max(worst.distance_m, std::abs(static_cast<double>(stored) - truth));
      ++worst.samples;
    }
  }
  EXPECT_GT(worst.samples, 100000);
  EXPECT_LE(worst.distance_m, GetParam().maxError_m);
  EXPECT_GT(worst.distance_m, 0.9 * GetParam().maxError_m) << "the bound is not made use of";

  const auto exact = builtPyramid(options(std::nullopt, "exact.tdb"));
  ASSERT_NE(exact, nullptr);
  const auto small = payloadBytes(*reader);
  const auto large = payloadBytes(*exact);
  std::printf("%s: %d samples off by at most %.6f m; %llu bytes, exact %llu\n", GetParam().path, worst.samples,
              worst.distance_m, static_cast<unsigned long long>(small), static_cast<unsigned long long>(large));
  // Each doubling of the step saves half a bit to a bit of some 5 to 12 a sample.
  const double doublings = std::log2(2.0 * GetParam().maxError_m * 16.0);
  EXPECT_LT(static_cast<double>(small), static_cast<double>(large) * (1.0 - 0.06 * doublings));
}

TEST_P(BoundedHeights, TilesKeepTheirPromisesAndErrorsCountTheBound) {
  if (!std::filesystem::exists(source())) GTEST_SKIP() << source() << " is not there";
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  BuildOptions shallow = options(GetParam().maxError_m, "bounded.tdb");
  const auto reader = builtPyramid(shallow);
  ASSERT_NE(reader, nullptr);
  const auto sound = verifyPyramid(shallow.output);
  ASSERT_TRUE(sound.has_value());
  EXPECT_TRUE(sound->sound()) << sound->faults.front();
  expectEdgesShared(*reader);
  expectDecimated(*reader);

  // Every level's surface against the source where the finest samples lie: the answer's bound holds them.
  const Grid grid = readGrid(source());
  const tiling::Tiling tiling(GetParam().scheme);
  std::vector<TileId> deepest = storedTiles(*reader);
  std::erase_if(deepest, [&](const TileId& id) { return id.level != reader->info().maxLevel; });
  ASSERT_FALSE(deepest.empty());
  auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  std::mt19937 random(seed);
  int compared = 0;
  for (int i = 0; i < 4000; ++i) {
    const TileId& id = deepest[random() % deepest.size()];
    const auto inside = [&] { return raster::kGutter + static_cast<int>(random() % (kCells + 1)); };
    const int column = inside();
    const int row = inside();
    const auto place = raster::placeOf(tiling, id, Kind::elevation, kCells, column, row);
    ASSERT_TRUE(place.has_value());
    const geo::Geodetic where = geo::geodeticFromDirection(*place);
    if (!isPlain(grid, where) || isNoData(heightsOf(loaded(*reader, id)).at(column, row))) continue;
    const double truth = grid.bilinear(where.lat.degrees(), where.lon.degrees());
    const int level = static_cast<int>(random() % static_cast<unsigned>(id.level + 1));
    const auto answer = query->at(*place, {.level = level});
    ASSERT_TRUE(answer.has_value()) << io::describe(answer.error());
    if (!*answer) continue;
    ++compared;
    EXPECT_LE(std::abs((*answer)->height_m - truth), (*answer)->errorBound_m)
        << "level " << level << " at " << where.lat.degrees() << " " << where.lon.degrees();
    EXPECT_GE((*answer)->errorBound_m, GetParam().maxError_m);
  }
  EXPECT_GT(compared, 2000);
}

INSTANTIATE_TEST_SUITE_P(RealTerrain, BoundedHeights,
                         ::testing::Values(Case{"mars/mola_dem_4ppd.tif", Scheme::cube, 0.5},
                                           Case{"mars/mola_dem_4ppd.tif", Scheme::healpix, 20.0},
                                           Case{"earth/srtm3_riviera_seam/N43E006.tif", Scheme::geographic, 0.1},
                                           Case{"earth/srtm3_riviera_seam/N43E006.tif", Scheme::cube, 1.0}));

TEST(StepForError, IsAsWideAsTheBoundAllowsAndNeverWider) {
  EXPECT_FALSE(stepForError(0.0, geo::earth()).has_value());
  EXPECT_EQ(*stepForError(1e-4, geo::earth()), 0.0) << "32-bit numbers alone are off by more";
  for (const geo::Body& body : {geo::earth(), geo::mars(), geo::moon()}) {
    for (double bound = 0.05; bound < 1e5; bound *= 1.7) {
      const double step = *stepForError(bound, body);
      EXPECT_LT(step, 2.0 * bound);
      EXPECT_GT(step, 2.0 * bound - 0.01);
    }
  }
}

TEST(MaxError, AnAppendKeepsTheDatabasesBoundAndRefusesAnother) {
  const TemporaryFolder folder;
  GridSpec coarse = degreesGrid(-180, -90, 180, 90, 72, 36);
  writeElevation(folder / "coarse.tif", coarse, [](int c, int r) { return 100.0 * std::sin(0.3 * c) + 7.0 * r; });
  GridSpec fine = degreesGrid(10, 10, 20, 20, 40, 40);
  writeElevation(folder / "fine.tif", fine, [](int c, int r) { return 900.0 + 3.0 * c + 2.0 * r; });
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {(folder / "coarse.tif").string()};
  options.maxError_m = 0.4;
  ASSERT_NE(builtPyramid(options), nullptr);

  BuildOptions append = options;
  append.append = true;
  append.inputs = {(folder / "fine.tif").string()};
  append.maxError_m = 0.2;
  const auto refused = buildPyramid(append);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("--max-error 0.4"), std::string::npos) << refused.error().message;
  append.maxError_m.reset();
  const auto reader = builtPyramid(append);
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(reader->summary()->maxError_m, 0.4);
  const auto sound = verifyPyramid(options.output);
  ASSERT_TRUE(sound.has_value());
  EXPECT_TRUE(sound->sound()) << sound->faults.front();
}

TEST(MaxError, OtherBoundsAreOtherBuildsAndImageryHasNone) {
  const TemporaryFolder folder;
  writeElevation(folder / "a.tif", degreesGrid(-180, -90, 180, 90, 36, 18), [](int c, int r) { return c + r; });
  BuildOptions options;
  options.output = folder / "out.tdb";
  options.inputs = {(folder / "a.tif").string()};
  const auto exact = keyOfBuild(options);
  options.maxError_m = 0.5;
  const auto half = keyOfBuild(options);
  options.maxError_m = 0.25;
  const auto quarter = keyOfBuild(options);
  ASSERT_TRUE(exact && half && quarter);
  EXPECT_NE(*exact, *half);
  EXPECT_NE(*half, *quarter);
  for (const double wrong : {0.0, -1.0, std::nan(""), 1e9}) {
    options.maxError_m = wrong;
    EXPECT_FALSE(keyOfBuild(options).has_value()) << wrong;
  }
  options.maxError_m = 0.5;
  options.kind = Kind::imagery;
  EXPECT_FALSE(keyOfBuild(options).has_value());
}

}  // namespace
}  // namespace tellurion::pyramid::testing
