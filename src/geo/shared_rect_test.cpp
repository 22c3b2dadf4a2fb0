#include "geo/shared_rect.h"

#include <gtest/gtest.h>

#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

double uniform(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

TEST(SharedRect, HoldsWhatBothHoldAndNothingElseWhereTheyMeetOnce) {
  std::mt19937 random(testSeed());
  const auto rect = [&random] {
    const double south = uniform(random, -80.0, 79.0);
    const double west = uniform(random, -180.0, 180.0);
    return GeoRect::fromDegrees(south, west, uniform(random, south, 80.0), west + uniform(random, 0.0, 180.0));
  };
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    const GeoRect a = rect();
    const GeoRect b = rect();
    const auto both = sharedRect(a, b);
    ASSERT_EQ(both.has_value(), a.intersects(b));
    const Angle lat = a.south + (a.north - a.south) * uniform(random, 0.0, 1.0);
    const Angle lon = a.west + a.width * uniform(random, 0.0, 1.0);
    if (b.contains(lat, lon)) {
      ASSERT_TRUE(both.has_value());
      ASSERT_TRUE(both->contains(lat, lon));
    }
    if (!both) continue;
    ++met;
    const Angle withinLat = both->south + (both->north - both->south) * uniform(random, 0.0, 1.0);
    const Angle withinLon = both->west + both->width * uniform(random, 0.0, 1.0);
    ASSERT_TRUE(a.contains(withinLat, withinLon) && b.contains(withinLat, withinLon));
    ASSERT_GE(both->west, Angle::degrees(-180.0));
    ASSERT_LT(both->west, Angle::degrees(180.0));
  }
  EXPECT_GT(met, 1000);
}

TEST(SharedRect, OfTwoThatMeetTwiceHoldsBothParts) {
  const GeoRect most = GeoRect::fromDegrees(-10.0, 10.0, 10.0, 350.0);
  const GeoRect seam = GeoRect::fromDegrees(-5.0, -30.0, 20.0, 40.0);
  for (const auto& both : {sharedRect(most, seam), sharedRect(seam, most)}) {
    ASSERT_TRUE(both.has_value());
    EXPECT_TRUE(both->contains(Angle::degrees(0.0), Angle::degrees(-20.0)));
    EXPECT_TRUE(both->contains(Angle::degrees(0.0), Angle::degrees(30.0)));
    EXPECT_NEAR(both->width.degrees(), 70.0, 1e-9);
    EXPECT_NEAR(both->north.degrees(), 10.0, 1e-9);
  }
  const auto all = sharedRect(GeoRect::whole(), seam);
  ASSERT_TRUE(all.has_value());
  EXPECT_NEAR(all->west.degrees(), -30.0, 1e-9);
  EXPECT_NEAR(all->width.degrees(), 70.0, 1e-9);
}

TEST(SharedRect, IsNothingWhereTheyDoNotMeet) {
  EXPECT_FALSE(sharedRect(GeoRect::fromDegrees(0, 0, 10, 10), GeoRect::fromDegrees(0, 20, 10, 30)).has_value());
  EXPECT_FALSE(sharedRect(GeoRect::fromDegrees(0, 0, 10, 10), GeoRect::fromDegrees(11, 0, 20, 10)).has_value());
}

}  // namespace
}  // namespace tellurion::geo
