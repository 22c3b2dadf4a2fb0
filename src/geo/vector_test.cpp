#include "geo/vector.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

Vec3 randomUnit(std::mt19937_64& random) {
  while (true) {
    const Vec3 v(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0));
    const double size = length(v);
    if (size > 0.1 && size <= 1.0) return v / size;
  }
}

TEST(RotatedBetween, IsTheSmallestRotation) {
  auto random = seededGenerator();
  for (int i = 0; i < 100000; ++i) {
    const Vec3 from = randomUnit(random);
    const Vec3 to = randomUnit(random);
    const Vec3 v = randomUnit(random) * 3.0;
    const Vec3 w = randomUnit(random);
    const double bound = 1e-14 / (1.0 + dot(from, to));
    ASSERT_NEAR(length(rotatedBetween(from, from, to) - to), 0.0, bound);
    // It keeps lengths, angles and handedness, and what is across both vectors stays: the axis.
    const Vec3 turned = rotatedBetween(v, from, to);
    ASSERT_NEAR(length(turned), 3.0, 3.0 * bound);
    ASSERT_NEAR(dot(turned, rotatedBetween(w, from, to)), dot(v, w), 3.0 * bound);
    ASSERT_NEAR(length(cross(turned, rotatedBetween(w, from, to)) - rotatedBetween(cross(v, w), from, to)), 0.0,
                6.0 * bound);
    const Vec3 axis = cross(from, to);
    ASSERT_NEAR(length(rotatedBetween(axis, from, to) - axis), 0.0, bound);
    ASSERT_NEAR(length(rotatedBetween(turned, to, from) - v), 0.0, 6.0 * bound);
  }
}

TEST(RotatedBetween, SameAndOpposite) {
  const Vec3 v(1.0, 2.0, 3.0);
  const Vec3 x(1.0, 0.0, 0.0);
  EXPECT_EQ(rotatedBetween(v, x, x), v);
  EXPECT_EQ(rotatedBetween(v, x, -x), -v);
  EXPECT_EQ(rotatedBetween(v, x, Vec3(0.0, 1.0, 0.0)), Vec3(-2.0, 1.0, 3.0));
  EXPECT_TRUE(std::isnan(rotatedBetween(v, x, Vec3(std::nan(""), 0.0, 0.0)).x));
}

}  // namespace
}  // namespace tellurion::geo
