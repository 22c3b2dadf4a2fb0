#include "raster/footprint.h"
#include "geo/seed_test.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::heightAt;
using testing::MadeRaster;
using testing::makeRaster;
using testing::openOrDie;
using testing::ScratchFolder;
using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

struct Place {
  const char* name;
  const char* reference;
  std::array<double, 6> transform;
  int width;
  int height;
};

const Place kPlaces[] = {
    {"small", "EPSG:4326", {8, 0.01, 0, 47, 0, -0.01}, 100, 100},
    {"date line", "EPSG:4326", {175, 0.1, 0, 5, 0, -0.1}, 100, 100},
    {"arctic", "EPSG:4326", {-180, 1, 0, 90, 0, -1}, 360, 20},
    {"world", "EPSG:4326", {0, 1, 0, 90, 0, -1}, 360, 180},
    {"one pixel", "EPSG:4326", {120.123, 1e-5, 0, -33.3, 0, -1e-5}, 1, 1},
    {"north pole", "EPSG:3995", {-1000000, 20000, 0, 1000000, 0, -20000}, 100, 100},
    {"south pole", "EPSG:3031", {-500000, 20000, 0, 600000, 0, -20000}, 50, 55},
    {"beside the pole", "EPSG:3031", {169960, 2000, 0, -5660, 0, -2000}, 211, 210},
    {"utm", "EPSG:32645", {478000, 30, 0, 3108140, 0, -30}, 800, 655},
    {"utm at the date line", "EPSG:32660", {700000, 1000, 0, 7000000, 0, -1000}, 300, 300},
    {"mercator world",
     "EPSG:3857",
     {-20037508.342789244, 156543.03392804097, 0, 20037508.342789244, 0, -156543.03392804097},
     256,
     256},
    {"sinusoidal",
     "+proj=sinu +lon_0=0 +R=6371007.181 +no_defs",
     {-20015109.354, 100075.546, 0, 10007554.677, 0, -100075.546},
     400,
     200},
    {"lambert", "EPSG:2154", {100000, 5000, 0, 7100000, 0, -5000}, 220, 200},
};

class FootprintTest : public ::testing::TestWithParam<Place> {};

MadeRaster madeAt(const Place& place) {
  return {.width = place.width,
          .height = place.height,
          .type = GDT_Byte,
          .transform = place.transform,
          .reference = place.reference,
          .value = [](int, int, int) { return 1.0; }};
}

geo::Direction inTile(const Tiling& tiling, const TileId& id, double s, double t) {
  return tiling.direction(tiling::rootPointIn(id, s, t));
}

/// Whether any of a grid of places of the tile, edges included, has data.
bool hasData(RasterFile& file, const Tiling& tiling, const TileId& id) {
  constexpr int kSide = 17;
  std::vector<geo::Direction> directions;
  for (int i = 0; i < kSide * kSide; ++i) {
    directions.push_back(inTile(tiling, id, i % kSide / (kSide - 1.0), i / kSide / (kSide - 1.0)));
  }
  std::vector<float> heights(directions.size(), kNoData);
  EXPECT_TRUE(file.sampleHeights(directions, {}, heights));
  return std::ranges::any_of(heights, [](float h) { return !isNoData(h); });
}

TEST_P(FootprintTest, NoTileWithDataIsMissedAndFewAreTakenInVain) {
  const ScratchFolder folder;
  makeRaster(folder.file("r.tif"), madeAt(GetParam()));
  auto file = openOrDie(folder.file("r.tif"), Kind::elevation);
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-0.2, 1.2);
  const geo::GeoRect bounds = file.info().bounds;
  for (const Scheme scheme : {Scheme::geographic, Scheme::cube, Scheme::healpix}) {
    const Tiling tiling(scheme);
    int touched = 0;
    int taken = 0;
    for (int i = 0; i < 1500; ++i) {
      // Tiles of all sizes around the raster.
      const double lat = (bounds.south + (bounds.north - bounds.south) * uniform(random)).degrees();
      const double lon = (bounds.west + bounds.width * uniform(random)).degrees();
      const int level = static_cast<int>(random() % 16);
      const TileId id = tiling.tileAt(geo::directionFromDegrees(std::clamp(lat, -90.0, 90.0), lon), level);
      const bool data = hasData(file, tiling, id);
      const bool may = file.mayTouch(tiling, id);
      ASSERT_TRUE(may || !data) << nameOf(scheme) << " level " << level << " x " << id.x << " y " << id.y;
      // The places tried do not show data that is smaller than the gaps between them.
      if (tiling.metrics(level).largestEdge > bounds.north - bounds.south) continue;
      touched += data ? 1 : 0;
      taken += may ? 1 : 0;
    }
    EXPECT_LE(taken, 1.3 * touched + 50) << nameOf(scheme);
  }
}

TEST_P(FootprintTest, FarAwayIsFalse) {
  const ScratchFolder folder;
  makeRaster(folder.file("r.tif"), madeAt(GetParam()));
  auto file = openOrDie(folder.file("r.tif"), Kind::elevation);
  if (file.info().bounds.width.degrees() > 90.0) return;  // Those cover much, or a pole: the other test says enough.
  const double lat = 0.5 * (file.info().bounds.south + file.info().bounds.north).degrees();
  const double lon = (file.info().bounds.west + file.info().bounds.width * 0.5).degrees();
  for (const Scheme scheme : {Scheme::geographic, Scheme::cube, Scheme::healpix}) {
    const Tiling tiling(scheme);
    for (const double away : {45.0, 90.0, 180.0}) {
      EXPECT_FALSE(file.mayTouch(tiling, tiling.tileAt(geo::directionFromDegrees(-lat, lon + away), 6)))
          << nameOf(scheme);
    }
  }
}

TEST_P(FootprintTest, BoundsHoldEveryPlaceWithData) {
  const ScratchFolder folder;
  makeRaster(folder.file("r.tif"), madeAt(GetParam()));
  auto file = openOrDie(folder.file("r.tif"), Kind::elevation);
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const double lat = -90.0 + 180.0 * uniform(random);
    const double lon = -180.0 + 360.0 * uniform(random);
    if (std::isnan(heightAt(file, lat, lon))) continue;
    ASSERT_TRUE(file.info().bounds.contains(geo::Angle::degrees(lat), geo::Angle::degrees(lon))) << lat << " " << lon;
  }
}

INSTANTIATE_TEST_SUITE_P(Everywhere, FootprintTest, ::testing::ValuesIn(kPlaces), [](const auto& param) {
  std::string name = param.param.name;
  std::ranges::replace(name, ' ', '_');
  return name;
});

TEST(FootprintOf, PolarBoundsReachThePoleAllAround) {
  const ScratchFolder folder;
  makeRaster(folder.file("n.tif"), madeAt(kPlaces[5]));
  const auto bounds = openOrDie(folder.file("n.tif"), Kind::elevation).info().bounds;
  EXPECT_EQ(bounds.north.degrees(), 90.0);
  EXPECT_NEAR(bounds.width.degrees(), 360.0, 1e-9);
  EXPECT_GT(bounds.south.degrees(), 75.0);
}

TEST(FootprintOf, AMercatorWorldHasNoGapAtTheDateLine) {
  const ScratchFolder folder;
  makeRaster(folder.file("m.tif"), madeAt(kPlaces[10]));
  auto file = openOrDie(folder.file("m.tif"), Kind::elevation);
  for (const double lon : {180.0, -180.0, 179.9999999, -179.9999999, 179.5, -179.5}) {
    EXPECT_FALSE(std::isnan(heightAt(file, 10.0, lon))) << lon;
    EXPECT_FALSE(std::isnan(heightAt(file, 10.0, lon, geo::Angle::degrees(5)))) << lon;
  }
}

}  // namespace
}  // namespace tellurion::raster
