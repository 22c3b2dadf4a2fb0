#include "scene/navigation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "geo/body.h"
#include "scene/pose.h"

namespace tellurion::scene {
namespace {

using geo::Angle;

constexpr double kHeld_px = 0.01;
constexpr Viewport kViewport{1024, 768};

// Smooth mountains of the size of the body's own: a few waves on the unit sphere, 15 km long at the shortest.
Ground mountains(const geo::Body& body) {
  const double size_m = 1e-3 * body.ellipsoid.semiMajorAxis_m();
  const auto height = [size_m](const geo::Direction& d) -> std::optional<double> {
    const geo::Vec3& n = d.n;
    return size_m * (0.6 * std::sin(9.0 * n.x + 4.0 * n.y) * std::cos(7.0 * n.z) +
                     0.25 * std::sin(61.0 * n.y + 23.0 * n.z)) +
           0.02 * size_m * std::sin(2100.0 * n.x) * std::sin(1900.0 * n.z + 400.0 * n.y);
  };
  return {body.ellipsoid, height};
}

struct World {
  std::string name;
  geo::Body body;
};

View viewAt(const Camera& camera, const Ground& ground) {
  return viewOf(camera, ground.ellipsoid, Angle::degrees(45), kViewport);
}

Camera camera(double lat, double lon, double height_m, double heading, double pitch) {
  return {.position = {.lat = Angle::degrees(lat), .lon = Angle::degrees(lon), .height_m = height_m},
          .heading = Angle::degrees(heading),
          .pitch = Angle::degrees(pitch),
          .roll = Angle::degrees(0)};
}

double offBy_px(const View& view, const Grip& grip, PixelPosition wished) {
  const auto seen = pixelOf(view, grip.point);
  return seen ? std::hypot(seen->x - wished.x, seen->y - wished.y) : 1e9;
}

double clearanceOf(const View& view, const Ground& ground) {
  const auto up = ground.ellipsoid.directionFromBody(view.eye);
  return ground.ellipsoid.geodeticFromBody(view.eye).height_m - ground.heightOrZero_m(up);
}

// What every gesture owes its user, whatever it was asked for.
void expectSane(const View& view, const Ground& ground, double clearance_m = kClearance_m) {
  ASSERT_TRUE(std::isfinite(geo::length(view.eye.m)));
  EXPECT_GE(clearanceOf(view, ground), clearance_m - 1e-6);
  const Pose pose = poseOf(view, ground.ellipsoid);
  EXPECT_NEAR(pose.roll.degrees(), 0.0, 1e-5);
  EXPECT_LE(std::abs(pose.pitch.degrees()), 90.0 + 1e-9);
  const geo::Mat3 unity = view.viewFromBody * glm::transpose(view.viewFromBody);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(unity[i][j], i == j ? 1.0 : 0.0, 1e-12);
  EXPECT_NEAR(glm::determinant(view.viewFromBody), 1.0, 1e-12);
}

// Cameras everywhere: every third close to a pole or to the date line, heights from metres to orbits, all pitches
// downwards.
class Cameras {
 public:
  Cameras(unsigned seed, const Ground& ground) : random_(seed), ground_(ground) {}

  Camera next() {
    double lat = std::asin(between(-1, 1)) * 180 / geo::kPi, lon = between(-180, 180);
    if (count_ % 6 == 1) lat = (count_ % 12 == 1 ? 1 : -1) * (90 - std::pow(10.0, between(-7, 1)));
    if (count_ % 6 == 4) lon = 180 + between(-1, 1) * std::pow(10.0, between(-6, 0));
    ++count_;
    const double above = 5.0 * std::pow(10.0, between(0, 6.5)) * ground_.ellipsoid.semiMajorAxis_m() / 6.4e6;
    const double base = ground_.heightOrZero_m(geo::directionFromDegrees(lat, lon));
    return camera(lat, lon, base + above + kClearance_m, between(-180, 180), between(-90, 5));
  }
  PixelPosition pixel() { return {between(0, kViewport.width), between(0, kViewport.height)}; }
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }

 private:
  std::mt19937 random_;
  const Ground& ground_;
  int count_ = 0;
};

class Navigation : public testing::TestWithParam<World> {
 protected:
  void SetUp() override { RecordProperty("seed", static_cast<int>(seed)); }
  const unsigned seed = 20240611;
  const Ground ground = mountains(GetParam().body);
  Cameras cameras{seed, ground};
};

TEST_P(Navigation, PoseAndViewAreTheSameThing) {
  for (int i = 0; i < 500; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    Camera c = cameras.next();
    c.roll = Angle::degrees(i % 2 ? 0 : cameras.between(-60, 60));
    const View view = viewAt(c, ground);
    const View again = viewOf(poseOf(view, ground.ellipsoid), ground.ellipsoid, view);
    EXPECT_LT(geo::length(again.eye - view.eye), 1e-6 + 1e-14 * geo::length(view.eye.m));
    for (int k = 0; k < 3; ++k)
      EXPECT_LT(geo::length(again.viewFromBody[k] - view.viewFromBody[k]), 1e-6);
  }
}

TEST_P(Navigation, PointUnderThePixelLiesOnTheGroundAndOnThePixel) {
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View view = viewAt(cameras.next(), ground);
    const auto grip = gripAt(view, cameras.pixel(), ground);
    if (!grip) continue;
    ++met;
    EXPECT_LT(offBy_px(view, *grip, grip->pixel), 1e-3);
    const auto up = ground.ellipsoid.directionFromBody(grip->point);
    EXPECT_NEAR(ground.ellipsoid.geodeticFromBody(grip->point).height_m, ground.heightOrZero_m(up), 1e-5);
  }
  EXPECT_GT(met, 100);
}

TEST_P(Navigation, PanHoldsThePoint) {
  int held = 0, tried = 0;
  for (int i = 0; i < 600; ++i) {
    const View start = viewAt(cameras.next(), ground);
    const auto grip = gripAt(start, cameras.pixel(), ground);
    const PixelPosition cursor = cameras.pixel();
    if (!grip) continue;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View view = panned(start, *grip, cursor, ground);
    expectSane(view, ground);
    ++tried;
    // Where the cursor ends off the body or at its rim, the point stays behind it; everywhere else it is held.
    if (pointUnder(start, cursor, ground) && offBy_px(view, *grip, cursor) < kHeld_px) ++held;
    const View back = panned(start, *grip, grip->pixel, ground);
    EXPECT_LT(offBy_px(back, *grip, grip->pixel), kHeld_px);
    EXPECT_LT(geo::length(back.eye - start.eye), 1e-3 * geo::length(grip->point - start.eye));
  }
  EXPECT_GT(held, tried / 2);
}

TEST_P(Navigation, PanHoldsThePointExactlyWhereTheGroundIsInFullView) {
  for (int i = 0; i < 600; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    Camera c = cameras.next();
    c.pitch = Angle::degrees(cameras.between(-90, -65));
    const double least = 300.0 + 2e-3 * ground.ellipsoid.semiMajorAxis_m();
    c.position.height_m = std::clamp(c.position.height_m, least, 0.1 * ground.ellipsoid.semiMajorAxis_m());
    const View start = viewAt(c, ground);
    const auto grip = gripAt(start, cameras.pixel(), ground);
    ASSERT_TRUE(grip);
    const PixelPosition cursor = cameras.pixel();
    const View view = panned(start, *grip, cursor, ground);
    EXPECT_LT(offBy_px(view, *grip, cursor), kHeld_px);
    const Pose before = poseOf(start, ground.ellipsoid), after = poseOf(view, ground.ellipsoid);
    EXPECT_NEAR(after.height_m, before.height_m, 1e-6 + 1e-12 * before.height_m);
    EXPECT_NEAR(after.pitch.degrees(), before.pitch.degrees(), 1e-6);
  }
}

TEST_P(Navigation, ZoomKeepsThePointAndTakesTenPercentOfTheDistance) {
  for (int i = 0; i < 600; ++i) {
    const View start = viewAt(cameras.next(), ground);
    const auto grip = gripAt(start, cameras.pixel(), ground);
    if (!grip) continue;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const double before_m = geo::length(grip->point - start.eye);
    for (const double steps : {1.0, 3.0, -1.0, -3.0}) {
      const View view = zoomed(start, *grip, steps, ground);
      expectSane(view, ground);
      const double after_m = geo::length(grip->point - view.eye);
      if (clearanceOf(view, ground) > kClearance_m + 1e-6 && before_m < 10 * ground.ellipsoid.semiMajorAxis_m()) {
        const bool straightDown = poseOf(view, ground.ellipsoid).pitch.degrees() < -90 + 1e-6;
        EXPECT_TRUE(offBy_px(view, *grip, grip->pixel) < kHeld_px || straightDown) << steps;
        const bool fits =
            before_m < 3 * kClearance_m || std::abs(after_m / (before_m * std::pow(kZoomStep, steps)) - 1.0) < 1e-6;
        EXPECT_TRUE(fits || steps < 0.0) << "from " << before_m << " to " << after_m;
      }
    }
  }
}

TEST_P(Navigation, ZoomingOnEndsAtTheGroundAndZoomingOutEndsFarAway) {
  for (int i = 0; i < 40; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    View view = viewAt(cameras.next(), ground);
    const PixelPosition pixel = cameras.pixel();
    for (int step = 0; step < 250; ++step) {
      const auto grip = gripAt(view, pixel, ground);
      view = grip ? zoomed(view, *grip, 1.0, ground) : climbed(view, 1.0, ground);
      expectSane(view, ground);
      if (HasFailure()) return;
    }
    EXPECT_LT(clearanceOf(view, ground), 100.0);
    for (int step = 0; step < 250; ++step) {
      const auto grip = gripAt(view, pixel, ground);
      view = grip ? zoomed(view, *grip, -1.0, ground) : climbed(view, -1.0, ground);
      expectSane(view, ground);
      if (HasFailure()) return;
    }
    const double height_m = ground.ellipsoid.geodeticFromBody(view.eye).height_m;
    EXPECT_LE(height_m, 20.001 * ground.ellipsoid.semiMajorAxis_m());
    EXPECT_GE(height_m, 15.0 * ground.ellipsoid.semiMajorAxis_m());
  }
}

TEST_P(Navigation, OrbitKeepsThePointAtItsPixelAndItsDistance) {
  int moved = 0;
  for (int i = 0; i < 300; ++i) {
    const View start = viewAt(cameras.next(), ground);
    const auto grip = gripAt(start, cameras.pixel(), ground);
    if (!grip) continue;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const geo::Vec2 drag(cameras.between(-500, 500), cameras.between(-300, 300));
    const View view = orbited(start, *grip, drag, ground);
    expectSane(view, ground);
    EXPECT_LT(offBy_px(view, *grip, grip->pixel), kHeld_px);
    const double before_m = geo::length(grip->point - start.eye);
    EXPECT_NEAR(geo::length(grip->point - view.eye), before_m, 1e-6 * before_m);
    if (geo::length(view.eye - start.eye) > 0.01 * before_m) ++moved;
  }
  EXPECT_GT(moved, 100);
}

TEST_P(Navigation, NorthUpTurnsNorthUpAroundThePoint) {
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const Camera c = cameras.next();
    const View start = viewAt(c, ground);
    const auto grip = gripAt(start, centreOf(kViewport), ground);
    const View view = northUp(start, grip, ground);
    expectSane(view, ground);
    if (std::abs(c.position.lat.degrees()) > 89.9) continue;
    EXPECT_NEAR(headingOf(poseOf(view, ground.ellipsoid)).degrees(), 0.0, 1e-5);
  }
}

TEST_P(Navigation, LookingAroundStaysInPlaceWithinItsLimits) {
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View start = viewAt(cameras.next(), ground);
    const View view = lookedAround(start, {cameras.between(-3000, 3000), cameras.between(-3000, 3000)}, ground);
    expectSane(view, ground);
    EXPECT_LT(geo::length(view.eye - start.eye), 1e-6 + 1e-14 * geo::length(start.eye.m));
  }
}

TEST_P(Navigation, GroundThatArrivesPushesTheEyeUp) {
  Ground nothing{ground.ellipsoid, {}};
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    Camera c = cameras.next();
    c.position.height_m = 3.0;
    const View start = viewAt(c, nothing);
    const View view = cleared(start, ground);
    expectSane(view, ground);
    const auto up = ground.ellipsoid.directionFromBody(start.eye);
    EXPECT_NEAR(ground.ellipsoid.geodeticFromBody(view.eye).height_m,
                std::max(3.0, ground.heightOrZero_m(up) + kClearance_m), 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, Navigation,
                         testing::Values(World{"Earth", geo::earth()}, World{"Mars", geo::mars()},
                                         World{"Moon", geo::moon()}, World{"Flat", {"flat", geo::Ellipsoid(1e6, 0.2)}}),
                         [](const auto& world) { return world.param.name; });

// ---- Single cases with names

TEST(NavigationCases, PanOverThePoleIsFreeAndComesBack) {
  const Ground ground{geo::earth().ellipsoid, {}};
  const View start = viewAt(camera(89.0, 30, 400e3, 0, -90), ground);
  const auto grip = gripAt(start, {512, 384}, ground);
  ASSERT_TRUE(grip);
  geo::BodyPosition last = start.eye;
  for (int y = 384; y <= 760; y += 4) {  // draws the ground down: the eye flies north over the pole and on
    const View view = panned(start, *grip, {512, static_cast<double>(y)}, ground);
    expectSane(view, ground);
    EXPECT_LT(offBy_px(view, *grip, {512, static_cast<double>(y)}), kHeld_px);
    EXPECT_LT(geo::length(view.eye - last), 10e3) << "no jump at y = " << y;
    last = view.eye;
  }
  EXPECT_NEAR(std::abs(geo::earth().ellipsoid.geodeticFromBody(last).lon.degrees()), 150.0, 1.0);
  EXPECT_EQ(panned(start, *grip, {512, 384}, ground).eye, panned(start, *grip, {512, 384}, ground).eye);
}

TEST(NavigationCases, EyeExactlyOverAPole) {
  for (const double lat : {90.0, -90.0}) {
    const Ground ground = mountains(geo::earth());
    const View start = viewAt(camera(lat, 0, 50e3, 70, -80), ground);
    const auto grip = gripAt(start, {300, 500}, ground);
    ASSERT_TRUE(grip);
    EXPECT_LT(offBy_px(panned(start, *grip, {700, 300}, ground), *grip, {700, 300}), kHeld_px);
    EXPECT_LT(offBy_px(zoomed(start, *grip, 2, ground), *grip, grip->pixel), kHeld_px);
    EXPECT_LT(offBy_px(orbited(start, *grip, {100, -30}, ground), *grip, grip->pixel), kHeld_px);
    expectSane(northUp(start, grip, ground), ground);
  }
}

TEST(NavigationCases, PanAcrossTheDateLineKeepsHeading) {
  const Ground ground{geo::earth().ellipsoid, {}};
  const View start = viewAt(camera(20, 179.9, 100e3, 25, -70), ground);
  const auto grip = gripAt(start, {512, 384}, ground);
  ASSERT_TRUE(grip);
  const View view = panned(start, *grip, {100, 384}, ground);
  EXPECT_LT(offBy_px(view, *grip, {100, 384}), kHeld_px);
  const Camera after = cameraOf(view, ground.ellipsoid);
  EXPECT_LT(after.position.lon.degrees(), 0.0);
  EXPECT_NEAR(after.heading.degrees(), 25.0, 1e-6);
}

TEST(NavigationCases, DraggingIntoTheSkyStopsAtTheRim) {
  const Ground ground{geo::earth().ellipsoid, {}};
  const View start = viewAt(camera(0, 0, 20000e3, 0, -90), ground);
  const auto grip = gripAt(start, {512, 384}, ground);
  ASSERT_TRUE(grip);
  const View far = panned(start, *grip, {1024, 384}, ground);
  expectSane(far, ground);
  const auto seen = pixelOf(far, grip->point);
  ASSERT_TRUE(seen);
  EXPECT_GT(seen->x, 600.0);
  EXPECT_NEAR(seen->y, 384.0, 0.5);
  EXPECT_LT(geo::length(far.eye - panned(start, *grip, {1020, 384}, ground).eye), 1.0) << "no motion beyond the rim";
}

TEST(NavigationCases, OrbitPassesNeitherTheZenithNorTheHorizon) {
  const Ground ground{geo::earth().ellipsoid, {}};
  const View start = viewAt(camera(45, 10, 5000, 0, -45), ground);
  const auto grip = gripAt(start, centreOf(kViewport), ground);
  ASSERT_TRUE(grip);
  EXPECT_NEAR(cameraOf(orbited(start, *grip, {0, 2000}, ground), ground.ellipsoid).pitch.degrees(), -90.0, 1e-3);
  const View low = orbited(start, *grip, {0, -2000}, ground);
  EXPECT_LT(clearanceOf(low, ground), 5.0) << "level with a point 7 km away is 4 m above the round Earth";
  EXPECT_LT(offBy_px(low, *grip, grip->pixel), kHeld_px);
}

TEST(NavigationCases, HalfATurnOfOrbitLooksBack) {
  const Ground ground{geo::earth().ellipsoid, {}};
  const View start = viewAt(camera(0, 10, 1000, 0, -30), ground);
  const auto grip = gripAt(start, centreOf(kViewport), ground);
  ASSERT_TRUE(grip);
  const Camera after = cameraOf(orbited(start, *grip, {768.0 / 2, 0}, ground), ground.ellipsoid);
  EXPECT_NEAR(after.heading.degrees(), 90.0, 0.05) << "a drag to the right turns the eye clockwise";
  EXPECT_NEAR(after.pitch.degrees(), -30.0, 0.05);
}

TEST(NavigationCases, RollIsKept) {
  const Ground ground{geo::earth().ellipsoid, {}};
  Camera c = camera(45, 10, 5000, 20, -50);
  c.roll = Angle::degrees(15);
  const View start = viewAt(c, ground);
  const auto grip = gripAt(start, {300, 300}, ground);
  ASSERT_TRUE(grip);
  for (const View& view : {panned(start, *grip, {500, 420}, ground), zoomed(start, *grip, 2, ground),
                           orbited(start, *grip, {40, 40}, ground)}) {
    EXPECT_NEAR(cameraOf(view, ground.ellipsoid).roll.degrees(), 15.0, 1e-6);
  }
  EXPECT_LT(offBy_px(orbited(start, *grip, {40, 40}, ground), *grip, grip->pixel), kHeld_px);
}

TEST(NavigationCases, MountainsHideWhatLiesBehindThem) {
  // A wall 1000 m high at longitude 0.1, seen from 0 towards the east.
  const auto wall = [](const geo::Direction& d) -> std::optional<double> {
    const double lon = std::atan2(d.n.y, d.n.x) * 180 / geo::kPi;
    return 1000.0 * std::exp(-std::pow((lon - 0.1) / 0.004, 2));
  };
  const Ground ground{geo::earth().ellipsoid, wall};
  const View view = viewAt(camera(0, 0, 500, 90, 0), ground);
  const auto hit = pointUnder(view, {512, 384}, ground);
  ASSERT_TRUE(hit);
  const geo::Geodetic g = ground.ellipsoid.geodeticFromBody(*hit);
  EXPECT_NEAR(g.height_m, 510.0, 15.0);
  EXPECT_NEAR(g.lon.degrees(), 0.0967, 2e-3);
  EXPECT_FALSE(pointUnder(view, {512, 100}, ground)) << "the sky above the wall";
}

TEST(NavigationCases, NothingIsHeldInTheSky) {
  const Ground ground{geo::mars().ellipsoid, {}};
  EXPECT_FALSE(gripAt(viewAt(camera(0, 0, 1000, 0, 20), ground), {512, 384}, ground));
  EXPECT_FALSE(gripAt(viewAt(camera(0, 0, 40e6, 0, -90), ground), {5, 5}, ground));
}

TEST(NavigationCases, GroundBelowTheEllipsoidIsMet) {
  const Ground ground{geo::mars().ellipsoid, [](const geo::Direction&) { return std::optional(-7000.0); }};
  const View view = viewAt(camera(-42, 70, 20e3, 10, -60), ground);
  const auto hit = pointUnder(view, {512, 384}, ground);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(ground.ellipsoid.geodeticFromBody(*hit).height_m, -7000.0, 1e-5);
  const View below = viewAt(camera(-42, 70, -6000, 10, -20), ground);
  const auto near = pointUnder(below, {512, 384}, ground);
  ASSERT_TRUE(near);
  EXPECT_NEAR(ground.ellipsoid.geodeticFromBody(*near).height_m, -7000.0, 1e-5);
}

}  // namespace
}  // namespace tellurion::scene
