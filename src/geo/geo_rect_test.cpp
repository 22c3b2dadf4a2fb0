#include "geo/geo_rect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

bool holds(const GeoRect& r, double lat, double lon) {
  return r.contains(Angle::degrees(lat), Angle::degrees(lon));
}

TEST(GeoRect, ClosedOnAllSides) {
  const GeoRect r = GeoRect::fromDegrees(10.0, 20.0, 30.0, 50.0);
  for (const double lat : {10.0, 20.0, 30.0}) {
    for (const double lon : {20.0, 33.3, 50.0, 380.0, -310.0})
      EXPECT_TRUE(holds(r, lat, lon)) << lat << " " << lon;
  }
  EXPECT_FALSE(holds(r, 9.999999, 30.0));
  EXPECT_FALSE(holds(r, 30.000001, 30.0));
  EXPECT_FALSE(holds(r, 20.0, 19.999999));
  EXPECT_FALSE(holds(r, 20.0, 50.000001));
}

TEST(GeoRect, AcrossTheDateLine) {
  const GeoRect r = GeoRect::fromDegrees(-10.0, 170.0, 10.0, -160.0);
  EXPECT_NEAR(r.width.degrees(), 30.0, 1e-12);
  EXPECT_NEAR(r.east().degrees(), 200.0, 1e-12);
  for (const double lon : {170.0, 180.0, -180.0, -160.0, 190.0, 200.0})
    EXPECT_TRUE(holds(r, 0.0, lon)) << lon;
  for (const double lon : {169.9, -159.9, 0.0})
    EXPECT_FALSE(holds(r, 0.0, lon)) << lon;
  const GeoRect sameIn360 = GeoRect::fromDegrees(-10.0, 170.0, 10.0, 200.0);
  EXPECT_NEAR(sameIn360.width.degrees(), 30.0, 1e-12);
  EXPECT_EQ(GeoRect::fromDegrees(0.0, 180.0, 1.0, -170.0).west, Angle::degrees(-180.0));
}

TEST(GeoRect, WholeAndMoreThanATurn) {
  for (const GeoRect& r : {GeoRect::whole(), GeoRect::fromDegrees(-90.0, 0.0, 90.0, 360.0),
                           GeoRect::fromDegrees(-90.0, -200.0, 90.0, 400.0)}) {
    EXPECT_EQ(r.width, Angle::degrees(360.0));
    for (const double lon : {-180.0, -0.0, 90.0, 180.0, 359.999})
      EXPECT_TRUE(holds(r, 0.0, lon)) << lon;
    EXPECT_TRUE(holds(r, 90.0, 12.0));
    EXPECT_TRUE(holds(r, -90.0, 12.0));
  }
  EXPECT_EQ(GeoRect::fromDegrees(0.0, 5.0, 1.0, 5.0).width, Angle());
}

TEST(GeoRect, APoleHasEveryLongitude) {
  const GeoRect cap = GeoRect::fromDegrees(80.0, 10.0, 90.0, 20.0);
  EXPECT_TRUE(holds(cap, 90.0, -100.0));
  EXPECT_FALSE(holds(cap, 89.0, -100.0));
  EXPECT_TRUE(cap.intersects(GeoRect::fromDegrees(85.0, -120.0, 90.0, -100.0)));
  EXPECT_FALSE(cap.intersects(GeoRect::fromDegrees(85.0, -120.0, 89.0, -100.0)));
  EXPECT_TRUE(GeoRect::fromDegrees(-90.0, 0.0, -80.0, 1.0).intersects(GeoRect::fromDegrees(-90.0, 9.0, -80.0, 10.0)));
}

TEST(GeoRect, Intersects) {
  const GeoRect r = GeoRect::fromDegrees(0.0, 170.0, 10.0, -170.0);
  EXPECT_TRUE(r.intersects(GeoRect::fromDegrees(5.0, -175.0, 15.0, 0.0)));
  EXPECT_TRUE(r.intersects(GeoRect::fromDegrees(10.0, 160.0, 15.0, 170.0)));  // they share a corner
  EXPECT_TRUE(r.intersects(GeoRect::fromDegrees(5.0, 175.0, 6.0, 176.0)));
  EXPECT_TRUE(GeoRect::fromDegrees(5.0, 175.0, 6.0, 176.0).intersects(r));
  EXPECT_FALSE(r.intersects(GeoRect::fromDegrees(5.0, -169.0, 6.0, 169.0)));
  EXPECT_FALSE(r.intersects(GeoRect::fromDegrees(11.0, 170.0, 12.0, 171.0)));
  EXPECT_TRUE(r.intersects(GeoRect::whole()));
}

TEST(GeoRect, UnitedTakesTheShorterWayRound) {
  const GeoRect a = GeoRect::fromDegrees(0.0, 170.0, 10.0, 175.0);
  const GeoRect b = GeoRect::fromDegrees(-5.0, -175.0, 5.0, -170.0);
  for (const GeoRect& u : {a.united(b), b.united(a)}) {
    EXPECT_NEAR(u.west.degrees(), 170.0, 1e-12);
    EXPECT_NEAR(u.width.degrees(), 20.0, 1e-12);
    EXPECT_NEAR(u.south.degrees(), -5.0, 1e-12);
    EXPECT_NEAR(u.north.degrees(), 10.0, 1e-12);
  }
  const GeoRect inner = GeoRect::fromDegrees(1.0, 171.0, 2.0, 172.0);
  EXPECT_NEAR(a.united(inner).width.degrees(), 5.0, 1e-12);
  EXPECT_NEAR(inner.united(a).width.degrees(), 5.0, 1e-12);
  EXPECT_EQ(GeoRect::whole().united(a).width, Angle::degrees(360.0));
}

TEST(GeoRect, UnitedHoldsBothAndIsOfTheOrderOfThem) {
  auto random = seededGenerator();
  const auto rect = [&random] {
    const double south = uniform(random, -90.0, 89.0);
    const double west = uniform(random, -180.0, 180.0);
    return GeoRect::fromDegrees(south, west, uniform(random, south, 90.0), west + uniform(random, 0.0, 360.0));
  };
  for (int i = 0; i < 20000; ++i) {
    const GeoRect a = rect();
    const GeoRect b = rect();
    const GeoRect u = a.united(b);
    ASSERT_LE(u.width, Angle::degrees(360.0));
    for (const GeoRect& part : {a, b}) {
      const Angle lat = part.south + (part.north - part.south) * uniform(random, 0.0, 1.0);
      const Angle lon = part.west + part.width * uniform(random, 0.0, 1.0);
      ASSERT_TRUE(u.contains(lat, lon));
      ASSERT_TRUE(part.contains(lat, lon));
      ASSERT_TRUE(u.contains(part.south, part.west));
      ASSERT_TRUE(u.contains(part.north, part.east()));
      const bool shared = a.contains(lat, lon) && b.contains(lat, lon);
      ASSERT_TRUE(!shared || (a.intersects(b) && b.intersects(a)));
    }
    ASSERT_GE(u.west, Angle::degrees(-180.0));
    ASSERT_LT(u.west, Angle::degrees(180.0));
  }
}

TEST(GeoRect, NothingHoldsNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(holds(GeoRect::whole(), nan, 0.0));
  EXPECT_FALSE(holds(GeoRect::whole(), 0.0, nan));
  EXPECT_FALSE(GeoRect::whole().intersects(GeoRect::fromDegrees(nan, nan, nan, nan)));
}

TEST(GeoRect, GrownHoldsAllThatIsNear) {
  std::mt19937_64 random = seededGenerator();
  for (int i = 0; i < 20000; ++i) {
    const double south = uniform(random, -90, 90);
    const double west = uniform(random, -180, 180);
    const GeoRect rect = GeoRect::fromDegrees(south, west, uniform(random, south, std::min(south + 20, 90.0)),
                                              west + uniform(random, 0, 30));
    const Angle by = Angle::degrees(std::exp(uniform(random, -9, 2.5)));
    const GeoRect grown = rect.grown(by);
    const Direction inside = directionFromLatLon(rect.south + (rect.north - rect.south) * uniform(random, 0, 1),
                                                 rect.west + rect.width * uniform(random, 0, 1));
    const Vec3 aside = normalize(cross(inside.n, Vec3(uniform(random, -1, 1), uniform(random, -1, 1), 0.3)));
    const double way = by.radians() * uniform(random, 0, 1);
    const Geodetic near = geodeticFromDirection({inside.n * std::cos(way) + aside * std::sin(way)});
    ASSERT_TRUE(grown.contains(near.lat, near.lon)) << near.lat.degrees() << " " << near.lon.degrees();
    ASSERT_GE(grown.south.degrees(), -90.0);
    ASSERT_LE(grown.width.degrees(), 360.0);
  }
  const GeoRect same = GeoRect::fromDegrees(1, 2, 3, 4).grown(Angle());
  EXPECT_EQ(same.west, Angle::degrees(2));
  EXPECT_NEAR(GeoRect::fromDegrees(-1, 2, 1, 4).grown(Angle::degrees(1)).width.degrees(), 4.0, 1e-3);
}

}  // namespace
}  // namespace tellurion::geo
