#include "geo/geodetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Direction, ExactAtPolesAndQuarterMeridians) {
  for (const double lon : {0.0, 17.0, -90.0, 180.0}) {
    EXPECT_EQ(directionFromDegrees(90.0, lon).n, Vec3(0.0, 0.0, 1.0));
    EXPECT_EQ(directionFromDegrees(-90.0, lon).n, Vec3(0.0, 0.0, -1.0));
    EXPECT_EQ(directionFromLatLon(Angle::degrees(90.0), Angle::degrees(lon)).n, Vec3(0.0, 0.0, 1.0));
  }
  EXPECT_EQ(directionFromDegrees(0.0, 180.0).n, Vec3(-1.0, 0.0, 0.0));
  EXPECT_EQ(directionFromDegrees(0.0, -180.0).n, Vec3(-1.0, 0.0, 0.0));
  EXPECT_EQ(directionFromLatLon(Angle(), Angle::degrees(-90.0)).n, Vec3(0.0, -1.0, 0.0));
  EXPECT_EQ(directionFromDegrees(30.0, 400.0), directionFromDegrees(30.0, 40.0));
}

TEST(Direction, RoundTripOfGeodetic) {
  auto random = seededGenerator();
  for (int i = 0; i < 100000; ++i) {
    const double lat = std::asin(uniform(random, -1.0, 1.0));
    const double lon = uniform(random, -kPi, kPi);
    const Direction d = directionFromLatLon(Angle::radians(lat), Angle::radians(lon));
    const Geodetic g = geodeticFromDirection(d);
    ASSERT_NEAR(g.lat.radians(), lat, 4e-16);
    ASSERT_NEAR((g.lon.radians() - lon) * std::cos(lat), 0.0, 1e-15);
    ASSERT_EQ(g.height_m, 0.0);
    ASSERT_NEAR(length(d.n), 1.0, 4e-16);
  }
}

TEST(Direction, PoleAndDateLineOfGeodetic) {
  EXPECT_EQ(geodeticFromDirection({Vec3(0.0, 0.0, 1.0)}).lat, Angle::degrees(90.0));
  EXPECT_EQ(geodeticFromDirection({Vec3(0.0, 0.0, -1.0)}).lat, Angle::degrees(-90.0));
  EXPECT_EQ(geodeticFromDirection({Vec3(-0.0, 0.0, 1.0)}).lon, Angle());
  EXPECT_EQ(geodeticFromDirection({Vec3(-1.0, -0.0, 0.0)}).lon, Angle::degrees(180.0));
}

TEST(AngleBetween, PreciseForSmallAndForOpposite) {
  const Direction a = directionFromDegrees(12.0, 34.0);
  EXPECT_EQ(angleBetween(a, a).radians(), 0.0);
  EXPECT_EQ(angleBetween({Vec3(1.0, 0.0, 0.0)}, {Vec3(-1.0, 0.0, 0.0)}).radians(), kPi);
  EXPECT_NEAR(angleBetween({Vec3(1.0, 0.0, 0.0)}, {Vec3(1.0, 1e-9, 0.0)}).radians(), 1e-9, 1e-24);
  EXPECT_NEAR(angleBetween({Vec3(1.0, 0.0, 0.0)}, {Vec3(-1.0, 1e-9, 0.0)}).radians(), kPi - 1e-9, 5e-16);
  EXPECT_DOUBLE_EQ(angleBetween({Vec3(1.0, 0.0, 0.0)}, {Vec3(0.0, 0.0, 1.0)}).degrees(), 90.0);
  EXPECT_TRUE(std::isnan(angleBetween(a, {Vec3(kNaN, 0.0, 0.0)}).radians()));
}

TEST(Direction, NanInNanOut) {
  EXPECT_TRUE(std::isnan(directionFromDegrees(kNaN, 0.0).n.z));
  EXPECT_TRUE(std::isnan(directionFromDegrees(0.0, kNaN).n.x));
  EXPECT_TRUE(std::isnan(geodeticFromDirection({Vec3(kNaN, 0.0, 0.0)}).lat.radians()));
}

}  // namespace
}  // namespace tellurion::geo
