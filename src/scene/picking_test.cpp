// Rays and pixels against the definition; the ground against closed forms and against a march with tiny steps.
#include "scene/picking.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

using geo::Angle;
using geo::Vec3;

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

View randomView(std::mt19937_64& random) {
  const double height_m = 100.0 * std::pow(10.0, geo::uniform(random, 0.0, 5.5));
  const Camera camera{.position = {.lat = Angle::radians(std::asin(geo::uniform(random, -1.0, 1.0))),
                                   .lon = Angle::degrees(geo::uniform(random, -180.0, 180.0)),
                                   .height_m = height_m},
                      .heading = Angle::degrees(geo::uniform(random, -180.0, 180.0)),
                      .pitch = Angle::degrees(geo::uniform(random, -90.0, 20.0)),
                      .roll = Angle::degrees(geo::uniform(random, -60.0, 60.0))};
  return viewOf(camera, kEarth, Angle::degrees(geo::uniform(random, 10.0, 100.0)), {640, 480});
}

PixelPosition randomPixel(std::mt19937_64& random) {
  return {geo::uniform(random, 0.0, 640.0), geo::uniform(random, 0.0, 480.0)};
}

Ground level(double height_m) {
  return {kEarth, [height_m](const geo::Direction&) { return height_m; }};
}

TEST(Picking, TheCentreLooksAheadAndTheEdgeIsHalfTheFieldOfView) {
  auto random = geo::seededGenerator();
  const View view = randomView(random);
  EXPECT_EQ(viewDirectionThrough(view, centreOf(view.viewport)), Vec3(0.0, 0.0, -1.0));
  const Vec3 top = viewDirectionThrough(view, {320.0, 0.0});
  EXPECT_NEAR(std::atan2(top.y, -top.z), 0.5 * view.verticalFov.radians(), 1e-14);
  EXPECT_EQ(top.x, 0.0);
  EXPECT_GT(viewDirectionThrough(view, {640.0, 240.0}).x, 0.0);
}

TEST(Picking, PixelAndRayAreInverse) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 5000; ++i) {
    const View view = randomView(random);
    const PixelPosition pixel = randomPixel(random);
    const geo::Ray ray = rayThrough(view, pixel);
    ASSERT_NEAR(geo::length(ray.direction), 1.0, 1e-14);
    ASSERT_EQ(ray.origin, view.eye);
    const double distance_m = std::pow(10.0, geo::uniform(random, 2.0, 7.0));
    const auto back = pixelOf(view, ray.origin + ray.direction * distance_m);
    ASSERT_TRUE(back.has_value());
    ASSERT_NEAR(back->x, pixel.x, 1e-5);
    ASSERT_NEAR(back->y, pixel.y, 1e-5);
    ASSERT_FALSE(pixelOf(view, ray.origin - ray.direction * distance_m).has_value());  // behind the eye
  }
}

TEST(Picking, LevelGroundIsTheRaisedEllipsoid) {
  auto random = geo::seededGenerator();
  int met = 0;
  for (int i = 0; i < 500; ++i) {
    const View view = randomView(random);
    const PixelPosition pixel = randomPixel(random);
    const double height_m = geo::uniform(random, 0.0, 90.0);
    const auto point = pointUnder(view, pixel, level(height_m));
    const geo::Ray ray = rayThrough(view, pixel);
    const auto truth = kEarth.intersect(ray, height_m);
    ASSERT_EQ(point.has_value(), truth.has_value());
    if (!point) continue;
    ++met;
    // A raised ellipsoid is not the surface of constant height, but by less than the flattening squared of that height.
    const double incidence = std::abs(geo::dot(ray.direction, kEarth.directionFromBody(*point).n));
    EXPECT_LT(geo::length(*point - (ray.origin + ray.direction * *truth)), (1e-5 * height_m + 1e-7) / incidence);
    EXPECT_NEAR(kEarth.geodeticFromBody(*point).height_m, height_m, 1e-7);
  }
  EXPECT_GT(met, 200);
}

TEST(Picking, TheFirstHillInTheWayIsMet) {
  const Ground hills{kEarth, [](const geo::Direction& d) {
                       return 1500.0 * (1.0 + std::sin(700.0 * d.n.x) * std::cos(500.0 * d.n.y + 300.0 * d.n.z));
                     }};
  const auto clearance_m = [&](const geo::BodyPosition& p) {
    return kEarth.geodeticFromBody(p).height_m - *hills.height_m(kEarth.directionFromBody(p));
  };
  auto random = geo::seededGenerator();
  int met = 0;
  for (int i = 0; i < 60; ++i) {
    const double lat = geo::uniform(random, -80.0, 80.0);
    const double lon = geo::uniform(random, -180.0, 180.0);
    const double ground_m = *hills.height_m(geo::directionFromDegrees(lat, lon));
    const Camera camera{.position = {.lat = Angle::degrees(lat),
                                     .lon = Angle::degrees(lon),
                                     .height_m = ground_m + geo::uniform(random, 10.0, 2000.0)},
                        .heading = Angle::degrees(geo::uniform(random, -180.0, 180.0)),
                        .pitch = Angle::degrees(geo::uniform(random, -20.0, 0.0)),
                        .roll = {}};
    const View view = viewOf(camera, kEarth, Angle::degrees(45), {640, 480});
    const geo::Ray ray = rayThrough(view, centreOf(view.viewport));
    const auto point = pointUnder(view, centreOf(view.viewport), hills);
    const double far_m = point ? geo::length(*point - ray.origin) : 300e3;
    constexpr int kSteps = 20000;
    for (int step = 0; step < kSteps; ++step) {
      const double t = far_m * step / kSteps;
      // It may lose what is thinner than half a pixel.
      ASSERT_GT(clearance_m(ray.origin + ray.direction * t), -0.5 * view.pixelAngle() * t - 1e-6) << i << " " << t;
    }
    if (!point) continue;
    ++met;
    EXPECT_NEAR(clearance_m(*point), 0.0, 1e-5);
  }
  EXPECT_GT(met, 20);
}

TEST(Picking, SkyUndergroundAndUnknownGround) {
  const Camera camera{.position = {.lat = Angle::degrees(10), .lon = Angle::degrees(20), .height_m = 1000.0},
                      .heading = {},
                      .pitch = Angle::degrees(-90),
                      .roll = {}};
  const View down = viewOf(camera, kEarth, Angle::degrees(45), {640, 480});
  const geo::Ray ray = rayThrough(down, centreOf(down.viewport));
  EXPECT_FALSE(groundAlong({ray.origin, -ray.direction}, level(0.0), down.pixelAngle()).has_value());
  EXPECT_EQ(groundAlong(ray, level(2000.0), down.pixelAngle()), ray.origin);  // already under it
  const Ground unknown{kEarth, [](const geo::Direction&) { return std::optional<double>(); }};
  const auto onEllipsoid = groundAlong(ray, unknown, down.pixelAngle());
  ASSERT_TRUE(onEllipsoid.has_value());
  EXPECT_NEAR(geo::length(*onEllipsoid - ray.origin), 1000.0, 1e-6);
  EXPECT_TRUE(groundAlong(ray, {kEarth, nullptr}, down.pixelAngle()).has_value());
}

TEST(Picking, AtTheRimTheEllipsoidCountsWhereSunkenGroundIsMissed) {
  // Ground 8 km down; a ray that dips into the ellipsoid, but not so deep.
  const double a = kEarth.semiMajorAxis_m();
  const geo::Ray ray{{Vec3(a - 1000.0, -2e6, 0.0)}, Vec3(0.0, 1.0, 0.0)};
  const auto point = groundAlong(ray, level(-8000.0), 1e-3);
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(kEarth.geodeticFromBody(*point).height_m, 0.0, 1e-5);
  EXPECT_FALSE(groundAlong({{Vec3(a + 1000.0, -2e6, 0.0)}, ray.direction}, level(-8000.0), 1e-3).has_value());
}

}  // namespace
}  // namespace tellurion::scene
