#include "pyramid/geometric_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tellurion::pyramid {
namespace {

using raster::Raster;
using tiling::TileId;

constexpr int kCells = 64;
constexpr ErrorScale kScale{.spacing_m = 1e9, .missing_m = 1e9};

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
    EXPECT_EQ(distanceToDescendant(id, plane, child, below, kScale), 0.0);
    const TileId deep = child.child(3).child(0);  // eight cells of its own to each of the tile's
    const auto deepBelow = heights([q](int c, int r) {
      const double x = ((q & 1) * 4 + 2) * 8 + c / 8.0;
      const double y = ((q >> 1) * 4 + 2) * 8 + r / 8.0;
      return static_cast<float>(8 * x - 24 * y);
    });
    EXPECT_EQ(distanceToDescendant(id, plane, deep, deepBelow, kScale), 0.0);
  }
}

TEST(DistanceToDescendant, FindsTheOneSampleThatDiffers) {
  std::mt19937 random(5);
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto flat = heights([](int, int) { return 100.0f; });
  for (int i = 0; i < 200; ++i) {
    auto below = flat;
    below.at(1 + static_cast<int>(random() % 65), 1 + static_cast<int>(random() % 65)) = 93.0f;
    EXPECT_NEAR(distanceToDescendant(id, flat, id.child(static_cast<int>(random() % 4)), below, kScale), 7.0, 1e-12);
  }
}

TEST(DistanceToDescendant, TheGutterDoesNotCount) {
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto flat = heights([](int, int) { return 100.0f; });
  auto below = flat;
  below.at(0, 30) = -9000.0f;
  below.at(66, 30) = -9000.0f;
  EXPECT_EQ(distanceToDescendant(id, flat, id.child(2), below, kScale), 0.0);
}

TEST(DistanceToDescendant, DataOverNoDataCountsAsMissing) {
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const auto none = heights([](int, int) { return raster::kNoData; });
  const auto flat = heights([](int, int) { return 100.0f; });
  const ErrorScale scale{.spacing_m = 1.0, .missing_m = 77.0};
  EXPECT_EQ(distanceToDescendant(id, none, id.child(0), flat, scale), 77.0);
  EXPECT_EQ(distanceToDescendant(id, flat, id.child(0), none, scale), 0.0);
}

/// At the rim of a gap what is finer is no further away than the tile's samples with data beside it: aside, and past
/// the heights between theirs.
TEST(DistanceToDescendant, AtAGapItIsADistanceInSpace) {
  const TileId id{.level = 0, .root = 0, .x = 0, .y = 0};
  const ErrorScale scale{.spacing_m = 10.0, .missing_m = 5000.0};
  const auto half = heights([](int c, int) { return c <= 10 ? static_cast<float>(100 * c) : raster::kNoData; });
  const auto steep = [](float beyond) {
    return heights([beyond](int c, int) {
      return c <= 20 ? static_cast<float>(50 * c) : c == 21 ? 1000.0f + beyond : raster::kNoData;
    });
  };
  const double cell_m = std::sqrt(2.0) * 10.0;
  EXPECT_NEAR(distanceToDescendant(id, half, id.child(0), steep(0.0f), scale), cell_m, 1e-9);
  EXPECT_NEAR(distanceToDescendant(id, half, id.child(0), steep(300.0f), scale), std::hypot(cell_m, 300.0), 1e-9);
  const ErrorScale low{.spacing_m = 10.0, .missing_m = 12.0};
  EXPECT_NEAR(distanceToDescendant(id, half, id.child(0), steep(0.0f), low), 12.0, 1e-9) << "no more than all there is";
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
