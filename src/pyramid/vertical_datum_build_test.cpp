// Builds whose inputs are above a geoid: what is stored is above the ellipsoid.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/seed_test.h"
#include "pyramid/height_query.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

/// Heights of 100 m over a part of the Alps, and a geoid that slopes to the north and east.
class VerticalDatumBuild : public ::testing::Test {
 protected:
  VerticalDatumBuild() {
    writeElevation(folder_ / "plain.tif", degreesGrid(6, 44, 10, 48, 80, 80), [](int, int) { return 100.0; });
    GridSpec geoid = degreesGrid(0, 40, 20, 50, 40, 20);
    geoid.type = SampleType::float32;
    writeElevation(folder_ / "geoid.tif", geoid, [](int c, int r) { return 40.0 + 0.25 * c - 0.5 * r; });
    options_.output = folder_ / "out.tdb";
    options_.inputs = {(folder_ / "plain.tif").string()};
  }
  TemporaryFolder folder_;
  BuildOptions options_;
};

TEST_F(VerticalDatumBuild, HeightsAreTheInputsAndTheGeoidsTogether) {
  options_.verticalDatum = (folder_ / "geoid.tif").string();
  const auto reader = builtPyramid(options_);
  ASSERT_NE(reader, nullptr);
  const auto query = HeightQuery::create(reader);
  ASSERT_TRUE(query.has_value());
  std::mt19937 random(geo::testSeed());
  std::uniform_real_distribution<double> lat(44.1, 47.9);
  std::uniform_real_distribution<double> lon(6.1, 9.9);
  for (int i = 0; i < 500; ++i) {
    const double north = lat(random);
    const double east = lon(random);
    const auto answer = query->at(geo::directionFromDegrees(north, east));
    ASSERT_TRUE(answer.has_value() && answer->has_value());
    const double geoid = 40.0 + 0.25 * (east / 0.5 - 0.5) - 0.5 * ((50.0 - north) / 0.5 - 0.5);
    EXPECT_NEAR((*answer)->height_m, 100.0 + geoid, 0.05) << north << " " << east;
  }
}

TEST_F(VerticalDatumBuild, AGeoidThatEndsTooSoonIsAFailureAndLeavesNothingInTheWay) {
  writeElevation(folder_ / "short.tif", degreesGrid(6, 44, 8, 48, 8, 16), [](int, int) { return 40.0; });
  options_.verticalDatum = (folder_ / "short.tif").string();
  const auto built = buildPyramid(options_);
  ASSERT_FALSE(built.has_value());
  EXPECT_NE(built.error().message.find("covers all inputs"), std::string::npos) << built.error().message;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.tdb.part"));
  options_.verticalDatum.clear();
  EXPECT_NE(builtPyramid(options_), nullptr);
}

TEST_F(VerticalDatumBuild, TheDatumAndItsGridAreInTheKeyAndImageryHasNone) {
  const auto plain = keyOfBuild(options_);
  options_.verticalDatum = (folder_ / "geoid.tif").string();
  const auto above = keyOfBuild(options_);
  std::filesystem::last_write_time(folder_ / "geoid.tif",
                                   std::filesystem::last_write_time(folder_ / "geoid.tif") + std::chrono::seconds(5));
  const auto changed = keyOfBuild(options_);
  ASSERT_TRUE(plain && above && changed);
  EXPECT_NE(*plain, *above);
  EXPECT_NE(*above, *changed);
  options_.kind = raster::Kind::imagery;
  EXPECT_FALSE(keyOfBuild(options_).has_value());
}

TEST_F(VerticalDatumBuild, RealMountainsStandAsHighAsTheGeoidPutsThem) {
  const std::filesystem::path shared = TELLURION_SHARED_DATA_DIR;
  const auto terrain = shared / "earth/srtm3_everest_N27E086.tif";
  const auto geoid = shared / "earth/egm96_geoid_15min.tif";
  if (!std::filesystem::exists(terrain) || !std::filesystem::exists(geoid)) GTEST_SKIP() << terrain << " is not there";
  options_.inputs = {terrain.string()};
  options_.maxLevel = 6;
  const auto plain = builtPyramid(options_);
  options_.output = folder_ / "above.tdb";
  options_.verticalDatum = geoid.string();
  const auto above = builtPyramid(options_);
  ASSERT_TRUE(plain && above);
  const auto over = HeightQuery::create(plain);
  const auto overEllipsoid = HeightQuery::create(above);
  ASSERT_TRUE(over && overEllipsoid);
  const Grid grid = readGrid(geoid);
  int compared = 0;
  for (double lat = 27.05; lat < 28.0; lat += 0.1) {
    for (double lon = 86.05; lon < 87.0; lon += 0.1) {
      const auto before = over->at(geo::directionFromDegrees(lat, lon));
      const auto after = overEllipsoid->at(geo::directionFromDegrees(lat, lon));
      ASSERT_TRUE(before && after);
      ASSERT_EQ(before->has_value(), after->has_value());
      if (!*before) continue;  // a void
      ++compared;
      // The grid is bilinear between its nodes, and what is stored between the database's samples.
      EXPECT_NEAR((*after)->height_m - (*before)->height_m, grid.bilinear(lat, lon), 0.15) << lat << " " << lon;
    }
  }
  EXPECT_GT(compared, 50);
}

}  // namespace
}  // namespace tellurion::pyramid::testing
