#include "pyramid/geometric_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tellurion::pyramid {
namespace {

using raster::Raster;
using tiling::TileId;

constexpr int kCells = 64;

Raster<float> heights(const std::function<float(int, int)>& height) {
  Raster<float> raster(kCells + 3, kCells + 3, raster::kNoData);
  for (int r = 0; r <= kCells; ++r) {
    for (int c = 0; c <= kCells; ++c)
      raster.at(c + 1, r + 1) = height(c, r);
  }
  return raster;
}

TEST(DistanceToDescendant, IsNothingForATileOfTheSamePlane) {
  const TileId id{.level = 3, .root = 1, .x = 5, .y = 2};
  const auto plane = heights([](int c, int r) { return static_cast<float>(8 * c - 24 * r); });
  for (int q = 0; q < 4; ++q) {
    const TileId child = id.child(q);
    const auto below =
        heights([q](int c, int r) { return static_cast<float>(4 * (c + (q & 1) * 64) - 12 * (r + (q >> 1) * 64)); });
    EXPECT_EQ(distanceToDescendant(id, plane, child, below, 1e9), 0.0);
    const TileId deep = child.child(3).child(0);  // eight cells of its own to each of the tile's
    const auto deepBelow = heights([q](int c, int r) {
      const double x = ((q & 1) * 4 + 2) * 8 + c / 8.0;
      const double y = ((q >> 1) * 4 + 2) * 8 + r / 8.0;
      return static_cast<float>(8 * x - 24 * y);
    });
    EXPECT_EQ(distanceToDescendant(id, plane, deep, deepBelow, 1e9), 0.0);
  }
}

TEST(DistanceToDescendant, FindsTheOneSampleThatDiffers) {
  std::mt19937 random(5);
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto flat = heights([](int, int) { return 100.0f; });
  for (int i = 0; i < 200; ++i) {
    auto below = flat;
    below.at(1 + static_cast<int>(random() % 65), 1 + static_cast<int>(random() % 65)) = 93.0f;
    EXPECT_NEAR(distanceToDescendant(id, flat, id.child(static_cast<int>(random() % 4)), below, 1e9), 7.0, 1e-12);
  }
}

TEST(DistanceToDescendant, TheGutterDoesNotCount) {
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto flat = heights([](int, int) { return 100.0f; });
  auto below = flat;
  below.at(0, 30) = -9000.0f;
  below.at(66, 30) = -9000.0f;
  EXPECT_EQ(distanceToDescendant(id, flat, id.child(2), below, 1e9), 0.0);
}

TEST(DistanceToDescendant, DataOverNoDataCountsAsMissing) {
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto none = heights([](int, int) { return raster::kNoData; });
  const auto flat = heights([](int, int) { return 100.0f; });
  EXPECT_EQ(distanceToDescendant(id, none, id.child(0), flat, 77.0), 77.0);
  EXPECT_EQ(distanceToDescendant(id, flat, id.child(0), none, 77.0), 0.0);
}

TEST(RoundedUp, IsNeverLess) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> values(0.0, 20000.0);
  for (int i = 0; i < 10000; ++i) {
    const double value = values(random);
    const float up = roundedUp(value);
    ASSERT_GE(static_cast<double>(up), value);
    ASSERT_LT(static_cast<double>(std::nextafter(up, -1.0f)), value);
  }
  EXPECT_EQ(roundedUp(0.0), 0.0f);
  EXPECT_EQ(roundedUp(0.5), 0.5f);
}

}  // namespace
}  // namespace tellurion::pyramid
