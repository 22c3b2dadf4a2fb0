#include "raster/bilinear.h"

#include <gtest/gtest.h>

#include <limits>

namespace tellurion::raster {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

TEST(Bilinear, BetweenFourHeights) {
  EXPECT_EQ(bilinearHeight({0, 4, 8, 12}, 0.0, 0.0), 0.0);
  EXPECT_EQ(bilinearHeight({0, 4, 8, 12}, 1.0, 1.0), 12.0);
  EXPECT_EQ(bilinearHeight({0, 4, 8, 12}, 0.5, 0.25), 4.0);
}

TEST(Bilinear, TheNearestCornerDecides) {
  EXPECT_FALSE(bilinearHeight({kNone, 4, 8, 12}, 0.4, 0.4));
  EXPECT_TRUE(bilinearHeight({kNone, 4, 8, 12}, 0.6, 0.4));
  EXPECT_EQ(bilinearHeight({kNone, 5, kNone, 5}, 0.6, 0.4), 5.0);
  EXPECT_NEAR(bilinearHeight({7, kNone, kNone, kNone}, 0.2, 0.2).value(), 7.0, 1e-12);
}

TEST(Bilinear, OfEquallyNearCornersAllMustHaveData) {
  EXPECT_FALSE(bilinearHeight({kNone, 4, 8, 12}, 0.5, 0.0));
  EXPECT_FALSE(bilinearHeight({4, kNone, 8, 12}, 0.5, 0.0));
  EXPECT_FALSE(bilinearHeight({4, 8, kNone, 12}, 0.5, 0.5));
  EXPECT_TRUE(bilinearHeight({4, 8, kNone, kNone}, 0.5, 0.0));
}

}  // namespace
}  // namespace tellurion::raster
