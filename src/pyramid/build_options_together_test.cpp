// Options of a build that meet: regions, vertical datums, bounded heights, cleaned imagery and blocks.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/build_run.h"
#include "pyramid/colour_query.h"
#include "pyramid/height_query.h"
#include "pyramid/imagery_cleaning.h"
#include "pyramid/synthetic_rasters_test.h"
#include "pyramid/verify.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Kind;
using raster::Rgba8;
using tiling::Scheme;
using tiling::TileId;

constexpr double kMaxError_m = 0.3;  // its step is no power of two

/// Ground and a geoid over a part of the Alps.
class OptionsTogether : public ::testing::TestWithParam<Scheme> {
 protected:
  OptionsTogether() {
    GridSpec ground = degreesGrid(6, 44, 10, 48, 160, 160);
    ground.type = SampleType::float32;
    writeElevation(folder_ / "ground.tif", ground, [](int c, int r) {
      return 900.0 + 400.0 * std::sin(0.11 * c) * std::cos(0.07 * r) + 3.0 * std::sin(1.9 * c + 0.7 * r);
    });
    GridSpec geoid = degreesGrid(0, 40, 20, 50, 40, 20);
    geoid.type = SampleType::float32;
    writeElevation(folder_ / "geoid.tif", geoid, [](int c, int r) { return 40.0 + 0.25 * c - 0.5 * r; });
  }
  BuildOptions elevation(const std::string& name) const {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {(folder_ / "ground.tif").string()};
    options.scheme = GetParam();
    options.maxError_m = kMaxError_m;
    options.verticalDatum = (folder_ / "geoid.tif").string();
    return options;
  }
  /// A dark picture over a bright one, both with a pattern.
  BuildOptions imagery(const std::string& name) const {
    BuildOptions options;
    options.output = folder_ / name;
    for (const int bright : {90, 0}) {
      const std::filesystem::path path = folder_ / fmt::format("picture{}.tif", bright);
      writeColour(path, degreesGrid(6, 44, 10, 48, 320, 320), [bright](int c, int r) {
        const auto wave = static_cast<std::uint8_t>(60.0 + bright + 40.0 * std::sin(0.02 * c) * std::cos(0.03 * r));
        const bool isHole = bright == 0 && std::hypot(c - 200, r - 90) < 40.0;
        return isHole ? Rgba8{} : Rgba8{wave, static_cast<std::uint8_t>(wave / 2), 70, 255};
      });
      options.inputs.push_back(path.string());
    }
    options.kind = Kind::imagery;
    options.scheme = GetParam();
    options.format = TileFormat::png;
    options.cleaning.feather_m = 30000.0;
    return options;
  }
  TemporaryFolder folder_;
};

TEST_P(OptionsTogether, HeightsOfARegionAreThoseOfTheWhole) {
  const auto whole = builtPyramid(elevation("whole.tdb"));
  BuildOptions some = elevation("some.tdb");
  some.region = geo::GeoRect::fromDegrees(45.2, 7.1, 46.7, 8.9);
  const auto part = builtPyramid(some);
  ASSERT_TRUE(whole && part);
  const auto ofWhole = HeightQuery::create(whole);
  const auto ofPart = HeightQuery::create(part);
  ASSERT_TRUE(ofWhole && ofPart);
  std::mt19937 random(geo::testSeed());
  std::uniform_real_distribution<double> lat(45.25, 46.65);
  std::uniform_real_distribution<double> lon(7.15, 8.85);
  int compared = 0;
  for (int i = 0; i < 500; ++i) {
    const geo::Direction place = geo::directionFromDegrees(lat(random), lon(random));
    const auto there = ofWhole->at(place);
    const auto here = ofPart->at(place);
    ASSERT_TRUE(there && *there && here);
    if (!*here) continue;  // between the outermost samples
    ++compared;
    EXPECT_EQ((*here)->height_m, (*there)->height_m);
    EXPECT_GE((*here)->errorBound_m, kMaxError_m);
  }
  EXPECT_GT(compared, 400);
  const auto report = verifyPyramid(some.output);
  ASSERT_TRUE(report.has_value());
  EXPECT_TRUE(report->sound()) << report->faults.front();
}

// A geoid need not reach beyond what of an input is built.
TEST_P(OptionsTogether, TheDatumIsWantedInTheRegionAlone) {
  GridSpec small = degreesGrid(7, 45, 9, 47, 8, 8);
  small.type = SampleType::float32;
  writeElevation(folder_ / "small.tif", small, [](int, int) { return 50.0; });
  BuildOptions options = elevation("out.tdb");
  options.verticalDatum = (folder_ / "small.tif").string();
  EXPECT_FALSE(buildPyramid(options).has_value());
  options.region = geo::GeoRect::fromDegrees(45.2, 7.2, 46.8, 8.8);
  EXPECT_NE(builtPyramid(options), nullptr);
}

// Along meridians and parallels (geographic) or not: as the input and the datum give them for directions.
TEST_P(OptionsTogether, SamplesOfTilesAreThoseOfDirections) {
  const auto plan = planBuild(elevation("out.tdb"), std::nullopt);
  ASSERT_TRUE(plan.has_value());
  auto file = raster::RasterFile::open(plan->inputs.front().path, Kind::elevation);
  ASSERT_TRUE(file.has_value());
  auto datum = raster::VerticalDatum::open(plan->verticalDatum, file->info().body, file->info().bounds);
  ASSERT_TRUE(datum.has_value());
  InputSet inputs(*plan, 1, std::size_t{8} << 20u);
  const tiling::Tiling tiling = plan->tiling();
  const int cells = plan->meta.tileCells;
  const auto side = static_cast<std::size_t>(raster::sideOf(Kind::elevation, cells));
  const auto around = tiling.tileAt(geo::directionFromDegrees(46.0, 8.0), plan->deepestLevel);
  const auto open = raster::openPlaces(tiling, around, Kind::elevation, cells, std::vector<bool>(side * side, false));
  const int input = 0;
  std::vector<float> onTile(open.indices.size(), raster::kNoData);
  ASSERT_TRUE(inputs.heights({&input, 1}, around, open.indices, onTile).has_value());
  std::vector<float> atPlaces(open.places.size(), raster::kNoData);
  ASSERT_TRUE(file->sampleHeights(open.places, plan->inputs.front().footprint, atPlaces).has_value());
  std::vector<double> zeros(open.places.size());
  ASSERT_TRUE(datum->heightsOfZero(open.places, zeros).has_value());
  int found = 0;
  for (std::size_t i = 0; i < onTile.size(); ++i) {
    if (raster::isNoData(onTile[i])) continue;
    ++found;
    EXPECT_NEAR(onTile[i], static_cast<double>(atPlaces[i]) + zeros[i], 2e-4);
  }
  EXPECT_GT(found, 1000);
}

/// All rows of a database that a plan makes, in blocks or level by level.
std::string rowsOf(const BuildPlan& plan, const std::filesystem::path& path) {
  auto database = TileDatabase::create(path, plan.meta, {.level = plan.startLevel(), .row = 0, .done = 0});
  EXPECT_TRUE(database.has_value());
  if (!database) return {};
  {
    const ProgressSink untold;  // the run keeps a reference
    BuildRun run(plan, *database, {.jobs = 2, .memoryBytes = kLeastMemory}, untold, {});
    const auto done = run.run({.level = plan.startLevel(), .row = 0, .done = 0});
    EXPECT_TRUE(done.has_value()) << io::describe(done.error());
  }
  auto rows = database->connection().prepare(
      "SELECT quote(id) || hex(payload) || quote(min_m) || quote(max_m) || "
      "quote(error_m) || quote(child_mask) FROM tiles ORDER BY id");
  EXPECT_TRUE(rows.has_value()) << io::describe(rows.error());
  std::string all;
  while (rows && *rows->step())
    all += rows->text(0) + "\n";
  return all;
}

TEST_P(OptionsTogether, BoundedHeightsInBlocksAreThoseOfLevelByLevel) {
  auto plan = planBuild(elevation("out.tdb"), std::nullopt);
  ASSERT_TRUE(plan.has_value());
  ASSERT_TRUE(plan->blockLevel.has_value());
  const std::string blocks = rowsOf(*plan, folder_ / "blocks.tdb");
  plan->blockLevel.reset();
  const std::string levels = rowsOf(*plan, folder_ / "levels.tdb");
  EXPECT_GT(blocks.size(), 10000u);
  EXPECT_TRUE(blocks == levels);
}

TEST_P(OptionsTogether, CleanedImageryInBlocksIsThatOfLevelByLevelWhateverTheMemory) {
  auto plan = planBuild(imagery("out.tdb"), std::nullopt);
  ASSERT_TRUE(plan.has_value());
  ASSERT_TRUE(plan->blockLevel.has_value());
  auto cleaned = ImageryCleaning::prepare(*plan, kLeastMemory * 2, {});
  ASSERT_TRUE(cleaned && *cleaned);
  EXPECT_GT((*cleaned)->bytes(), 1000u);
  plan->cleaned = *cleaned;
  const std::string blocks = rowsOf(*plan, folder_ / "blocks.tdb");
  cleaned = ImageryCleaning::prepare(*plan, kLeastMemory * 8, {});
  ASSERT_TRUE(cleaned && *cleaned);
  plan->cleaned = *cleaned;
  plan->blockLevel.reset();
  const std::string levels = rowsOf(*plan, folder_ / "levels.tdb");
  EXPECT_GT(blocks.size(), 10000u);
  EXPECT_TRUE(blocks == levels);
}

TEST_P(OptionsTogether, MapsThatDoNotFitTheMemorySaySo) {
  BuildOptions options = imagery("out.tdb");
  options.memoryBytes = kLeastMemory;
  const auto built = buildPyramid(options);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("MiB of memory: give it with --memory"), std::string::npos)
      << io::describe(built.error());
  options.memoryBytes = kLeastMemory * 2;
  EXPECT_NE(builtPyramid(options), nullptr);
}

// A region's edge is no border of the picture: nothing fades there.
TEST_P(OptionsTogether, ARegionIsFeatheredAsTheWhole) {
  const auto whole = builtPyramid(imagery("whole.tdb"));
  BuildOptions some = imagery("some.tdb");
  some.region = geo::GeoRect::fromDegrees(45.0, 7.0, 47.9, 9.0);
  const auto part = builtPyramid(some);
  ASSERT_TRUE(whole && part);
  const auto ofWhole = ColourQuery::create(whole);
  const auto ofPart = ColourQuery::create(part);
  ASSERT_TRUE(ofWhole && ofPart);
  // The maps' nodes lie elsewhere: a ramp of 16 of them moves by one at most, where it rises by 1.5/16 of 90 a node.
  constexpr double kMostOff = 90.0 * 1.5 / 16.0 + 1.0;
  int compared = 0;
  for (double lat = 45.05; lat < 47.85; lat += 0.04) {
    for (double lon = 7.05; lon < 8.95; lon += 0.04) {
      const auto there = ofWhole->at(geo::directionFromDegrees(lat, lon));
      const auto here = ofPart->at(geo::directionFromDegrees(lat, lon));
      ASSERT_TRUE(there && *there && here && *here) << lat << " " << lon;
      ++compared;
      EXPECT_NEAR((*here)->colour.r, (*there)->colour.r, kMostOff) << lat << " " << lon;
    }
  }
  EXPECT_GT(compared, 1000);
}

INSTANTIATE_TEST_SUITE_P(Schemes, OptionsTogether, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
