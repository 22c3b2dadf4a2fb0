#include "geo/local_frame.h"

#include <gtest/gtest.h>

#include <GeographicLib/LocalCartesian.hpp>
#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

Geodetic at(double lat, double lon, double height_m = 0.0) {
  return {.lat = Angle::degrees(lat), .lon = Angle::degrees(lon), .height_m = height_m};
}

TEST(LocalFrame, RightHandedUnitAxes) {
  auto random = seededGenerator();
  for (int i = 0; i < 10000; ++i) {
    const LocalFrame f =
        localFrameAt(earth().ellipsoid, at(uniform(random, -90.0, 90.0), uniform(random, -180.0, 180.0)));
    ASSERT_NEAR(length(f.east), 1.0, 4e-16);
    ASSERT_NEAR(length(f.north), 1.0, 4e-16);
    ASSERT_NEAR(length(f.up), 1.0, 4e-16);
    ASSERT_LT(length(cross(f.east, f.north) - f.up), 5e-16);
  }
}

TEST(LocalFrame, AgreesWithGeographicLib) {
  auto random = seededGenerator();
  for (int i = 0; i < 10000; ++i) {
    const double lat = uniform(random, -90.0, 90.0);
    const double lon = uniform(random, -180.0, 180.0);
    const double height_m = uniform(random, -1e4, 1e6);
    const GeographicLib::LocalCartesian reference(lat, lon, height_m);
    const LocalFrame f = localFrameAt(earth().ellipsoid, at(lat, lon, height_m));
    const Vec3 enu(uniform(random, -1e4, 1e4), uniform(random, -1e4, 1e4), uniform(random, -1e4, 1e4));
    double backLat = 0.0;
    double backLon = 0.0;
    double backHeight_m = 0.0;
    reference.Reverse(enu.x, enu.y, enu.z, backLat, backLon, backHeight_m);
    const BodyPosition expected = earth().ellipsoid.bodyFromGeodetic(at(backLat, backLon, backHeight_m));
    ASSERT_LT(length(f.origin.m + f.bodyFromEnu() * enu - expected.m), 2e-8);
  }
}

TEST(LocalFrame, AtThePolesEastFollowsTheLongitude) {
  const LocalFrame north = localFrameAt(earth().ellipsoid, at(90.0, 90.0));
  EXPECT_EQ(north.east, Vec3(-1.0, 0.0, 0.0));
  EXPECT_EQ(north.north, Vec3(0.0, -1.0, 0.0));
  EXPECT_EQ(north.up, Vec3(0.0, 0.0, 1.0));
  const LocalFrame south = localFrameAt(earth().ellipsoid, at(-90.0, 0.0));
  EXPECT_EQ(south.east, Vec3(0.0, 1.0, 0.0));
  EXPECT_EQ(south.north, Vec3(1.0, 0.0, 0.0));
  EXPECT_EQ(south.up, Vec3(0.0, 0.0, -1.0));
  const LocalFrame close = localFrameAt(earth().ellipsoid, at(90.0 - 1e-9, 90.0));
  EXPECT_LT(length(close.east - north.east), 1e-10);
}

TEST(LocalFrame, OnTheDateLine) {
  EXPECT_EQ(localFrameAt(moon().ellipsoid, at(0.0, 180.0)).east, Vec3(0.0, -1.0, 0.0));
  EXPECT_EQ(localFrameAt(moon().ellipsoid, at(0.0, -180.0)).east, Vec3(0.0, -1.0, 0.0));
}

}  // namespace
}  // namespace tellurion::geo
