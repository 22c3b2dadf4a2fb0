// Distances against brute force, maps against what they were made of.
#include "raster/weight_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

/// By the definition: every node against every unmarked one, and against the border where it counts.
double farBrute(const LonLatGrid& grid, const Raster<std::uint8_t>& marked, const geo::Body& body, int col, int row,
                double most_m, bool borderCounts) {
  if (marked.at(col, row) == 0) return 0.0;
  const double dx = grid.columnStep_m(body, row);
  const double dy = grid.rowStep_m(body);
  double least = most_m;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      if (marked.at(c, r) != 0) continue;
      int columns = std::abs(c - col);
      if (grid.wraps()) columns = std::min(columns, grid.width - columns);
      least = std::min(least, std::hypot(columns * dx, (r - row) * dy));
    }
  }
  if (borderCounts && !grid.wraps()) least = std::min(least, (std::min(col, grid.width - 1 - col) + 0.5) * dx);
  if (borderCounts && grid.bounds.north.degrees() < 89.0) least = std::min(least, (row + 0.5) * dy);
  if (borderCounts && grid.bounds.south.degrees() > -89.0) least = std::min(least, (grid.height - row - 0.5) * dy);
  return least;
}

TEST(WeightMap, DistancesAreThoseOfEveryNodeToEveryOther) {
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const geo::GeoRect& bounds : {geo::GeoRect::fromDegrees(40, 10, 50, 30),
                                     geo::GeoRect::fromDegrees(-20, 170, 20, -150), geo::GeoRect::whole()}) {
    for (const bool borderCounts : {false, true}) {
      for (const double most_m : {3e5, 4e6}) {
        const LonLatGrid grid{.bounds = bounds, .width = 37, .height = 23};
        Raster<std::uint8_t> marked(grid.width, grid.height);
        for (std::uint8_t& m : marked.samples)
          m = random() % 40 != 0 ? 1 : 0;
        const auto distances = distancesToUnmarked(grid, marked, geo::earth(), most_m, borderCounts);
        for (int r = 0; r < grid.height; ++r) {
          for (int c = 0; c < grid.width; ++c) {
            const double expected = farBrute(grid, marked, geo::earth(), c, r, most_m, borderCounts);
            ASSERT_NEAR(distances.at(c, r), expected, 1e-5 * expected + 0.01) << c << " " << r << " " << borderCounts;
          }
        }
      }
    }
  }
}

TEST(WeightMap, NothingUnmarkedIsAsFarAsIsAskedFor) {
  const LonLatGrid grid{.bounds = geo::GeoRect::whole(), .width = 8, .height = 4};
  const auto distances =
      distancesToUnmarked(grid, Raster<std::uint8_t>(8, 4, std::uint8_t{1}), geo::earth(), 5000.0, true);
  for (const float d : distances.samples)
    EXPECT_EQ(d, 5000.0f);
}

TEST(WeightMap, IsItsNodesAndBilinearBetweenThemAcrossTheDateLineToo) {
  LonLatGrid grid{.bounds = geo::GeoRect::whole(), .width = 36, .height = 18};
  WeightMap map{grid, Raster<std::uint8_t>(36, 18)};
  std::mt19937 random(3);
  for (std::uint8_t& w : map.weights.samples)
    w = static_cast<std::uint8_t>(random());
  for (int r = 0; r < 18; ++r) {
    const auto places = grid.places(r);
    for (int c = 0; c < 36; ++c)
      EXPECT_NEAR(map.at(places[static_cast<std::size_t>(c)]), map.weights.at(c, r) / 255.0, 1e-9);
  }
  const double across = map.at(geo::directionFromDegrees(grid.latitude(5).degrees(), 180.0));
  EXPECT_NEAR(across, (map.weights.at(35, 5) + map.weights.at(0, 5)) / 510.0, 1e-9);
}

TEST(WeightMap, GridsAreAsFineAsAskedForOrAsLargeAsAllowed) {
  const auto bounds = geo::GeoRect::fromDegrees(60, 0, 70, 40);
  const LonLatGrid fine = gridOfSpacing(bounds, geo::Angle::degrees(0.1), 8192);
  EXPECT_EQ(fine.height, 100);
  EXPECT_EQ(fine.width, 200) << "at 60 degrees a degree of longitude is half as long";
  const LonLatGrid capped = gridOfSpacing(bounds, geo::Angle::degrees(1e-9), 64);
  EXPECT_EQ(capped.width, 64);
  EXPECT_EQ(capped.height, 64);
}

TEST(WeightMap, RampsRiseFromNothingToAllWithoutKinks) {
  EXPECT_EQ(rampOf(0.0, 10.0), 0.0);
  EXPECT_EQ(rampOf(10.0, 10.0), 1.0);
  EXPECT_EQ(rampOf(99.0, 10.0), 1.0);
  EXPECT_DOUBLE_EQ(rampOf(5.0, 10.0), 0.5);
  for (double d = 0.0; d < 10.0; d += 0.1)
    EXPECT_LE(rampOf(d, 10.0), rampOf(d + 0.1, 10.0));
  EXPECT_EQ(rampOf(0.0, 0.0), 0.0);
  EXPECT_EQ(rampOf(0.1, 0.0), 1.0);
}

}  // namespace
}  // namespace tellurion::raster
