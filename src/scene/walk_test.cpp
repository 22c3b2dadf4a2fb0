#include "scene/walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "geo/body.h"
#include "raster/raster_file.h"
#include "scene/pose.h"

namespace tellurion::scene {
namespace {

using geo::Angle;

const geo::Body kEarth = geo::earth();
constexpr Viewport kViewport{640, 480};

View viewAt(double lat, double lon, double height_m, double heading, double pitch, const Ground& ground) {
  const Camera camera{.position = {.lat = Angle::degrees(lat), .lon = Angle::degrees(lon), .height_m = height_m},
                      .heading = Angle::degrees(heading),
                      .pitch = Angle::degrees(pitch),
                      .roll = Angle::degrees(0)};
  return viewOf(camera, ground.ellipsoid, Angle::degrees(45), kViewport);
}

double height_m(const View& view, const Ground& ground) {
  return ground.ellipsoid.geodeticFromBody(view.eye).height_m;
}

double over_m(const View& view, const Ground& ground) {
  return height_m(view, ground) - ground.heightOrZero_m(ground.ellipsoid.directionFromBody(view.eye));
}

Ground level(double height_m = 0.0) {
  return {kEarth.ellipsoid, [height_m](const geo::Direction&) { return std::optional(height_m); }};
}

/// ETOPO5, every 10 minutes.
class Relief {
 public:
  Relief() {
    auto file =
        raster::RasterFile::open(TELLURION_SOURCE_DIR "/data/earth/etopo5_dem_10min.tif", raster::Kind::elevation);
    if (file) file_.emplace(std::move(*file));
  }
  bool found() const { return file_.has_value(); }
  Ground ground() {
    return {kEarth.ellipsoid, [this](const geo::Direction& d) -> std::optional<double> {
              float height = 0.0F;
              if (!file_->sampleHeights({&d, 1}, {}, {&height, 1})) return std::nullopt;
              return height;
            }};
  }

 private:
  std::optional<raster::RasterFile> file_;
};

TEST(Walk, NeverBelowRealGroundWhateverIsAsked) {
  Relief relief;
  ASSERT_TRUE(relief.found());
  const Ground ground = relief.ground();
  std::mt19937 random(7);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
  for (int i = 0; i < 40; ++i) {
    SCOPED_TRACE(i);
    const bool polar = i % 4 == 1;
    const double lat = polar ? 89.9999 : between(27, 31), lon = i % 4 == 2 ? 179.9999 : between(80, 95);
    Walker walker{cleared(viewAt(lat, lon, between(-100, 9000), between(-180, 180), between(-90, 90), ground), ground),
                  0};
    View flier = walker.view;
    const double pitch = poseOf(flier, ground.ellipsoid).pitch.degrees();
    for (int k = 0; k < 20; ++k) {
      const Stride stride{std::round(between(-1.4, 1.4)), std::round(between(-1.4, 1.4)),
                          std::round(between(-1.4, 1.4))};
      const double seconds = std::pow(10.0, between(-3, -0.5));
      walker = walked(walker, stride, std::pow(10.0, between(0, 4)), seconds, ground);
      flier = flown(flier, stride, std::pow(10.0, between(-1, 1)), seconds, ground);
      for (const View& view : {walker.view, flier}) {
        ASSERT_GE(over_m(view, ground), kClearance_m - 1e-6);
        const Pose pose = poseOf(view, ground.ellipsoid);
        EXPECT_NEAR(pose.pitch.degrees(), pitch, 1e-6);
        EXPECT_NEAR(pose.roll.degrees(), 0.0, 1e-5);
      }
    }
  }
}

TEST(Walk, AQuarterOfAMeridianTakesAsLongAsItIsLong) {
  constexpr double kQuarter_m = 10001965.729;  // of WGS 84, as published
  const Ground ground = level(-kClearance_m);  // the eye at height 0
  for (const double lon : {0.0, 180.0, -77.0}) {
    const Walker start{viewAt(0, lon, 0, 0, -10, ground), 0};
    const Walker end = walked(start, {.ahead = 1}, kQuarter_m / 100.0, 100.0, ground);
    EXPECT_LT(geo::length(end.view.eye.m - geo::Vec3(0, 0, kEarth.ellipsoid.semiMinorAxis_m())), 1e-4 * kQuarter_m);
    // And on over the pole, down the meridian on the other side.
    const Walker over = walked(end, {.ahead = 1}, kQuarter_m / 100.0, 50.0, ground);
    const geo::Geodetic there = ground.ellipsoid.geodeticFromBody(over.view.eye);
    EXPECT_NEAR(there.lat.degrees(), 45.0, 0.2);
    EXPECT_NEAR(std::remainder(there.lon.degrees() - lon - 180.0, 360.0), 0.0, 1e-6);
    EXPECT_NEAR(std::abs(headingOf(poseOf(over.view, ground.ellipsoid)).degrees()), 180.0, 1e-6);
  }
  const Walker start{viewAt(0, 170, 0, 90, 0, ground), 0};
  const double round_m = 2.0 * geo::kPi * kEarth.ellipsoid.semiMajorAxis_m();
  const Walker back = walked(start, {.ahead = 1}, round_m / 100.0, 100.0, ground);
  EXPECT_LT(geo::length(back.view.eye - start.view.eye), 1e-4 * round_m);
}

TEST(Walk, SpeedIsRightOverThePoleAndTheDateLine) {
  const Ground ground = level();
  struct Case {
    double lat, lon, heading;
  };
  constexpr std::array<Case, 4> kCases{{{89.9999, 20, 0}, {-89.99995, 20, 170}, {10, 179.9999, 90}, {46, 8, 33}}};
  for (const Case& c : kCases) {
    for (const Stride& stride : {Stride{1, 0, 0}, Stride{-1, 0, 0}, Stride{0, 1, 0}, Stride{1, 1, 0}}) {
      Walker walker{viewAt(c.lat, c.lon, kClearance_m, c.heading, 5, ground), 0};
      const geo::BodyPosition first = walker.view.eye;
      double way_m = 0.0;
      for (int i = 0; i < 40; ++i) {
        const geo::BodyPosition before = walker.view.eye;
        walker = walked(walker, stride, 7.0, 0.1, ground);
        way_m += geo::length(walker.view.eye - before);
      }
      EXPECT_NEAR(way_m, 28.0, 0.01);
      EXPECT_NEAR(geo::length(walker.view.eye - first), 28.0, 0.01) << "straight on";
    }
  }
}

TEST(Walk, TheSameAtAnyRateOfFrames) {
  Relief relief;
  ASSERT_TRUE(relief.found());
  const Ground ground = relief.ground();
  const View start = cleared(viewAt(27.9, 86.9, 0, 40, -3, ground), ground);
  const auto after = [&](double frame_s, double& flown_over_m) {
    Walker walker{start, 0};
    View flier = cleared(viewAt(27.9, 86.9, 20000, 40, -30, ground), ground);
    const int frames = static_cast<int>(std::lround(3.0 / frame_s));
    for (int i = 0; i < frames; ++i) {
      walker = walked(walker, {.ahead = 1, .right = 0.5}, 400.0, frame_s, ground);
      flier = flown(flier, {.ahead = 1}, 0.5, frame_s, ground);
    }
    flown_over_m = over_m(flier, ground);
    return walker.view.eye;
  };
  double once_over_m = 0.0;
  const geo::BodyPosition once = after(3.0, once_over_m);
  for (const double frame_s : {0.5, 1.0 / 15, 1.0 / 60, 1.0 / 240}) {
    double flown_over_m = 0.0;
    EXPECT_LT(geo::length(after(frame_s, flown_over_m) - once), 0.5) << frame_s << " of 1200 m";
    EXPECT_NEAR(flown_over_m / once_over_m, 1.0, 1e-3) << frame_s;
  }
}

TEST(Walk, SinksWithoutABounceAndComesToStand) {
  const Ground ground = level(100.0);
  for (const double high_m : {0.5, 30.0, 500.0}) {
    Walker walker{viewAt(46, 8, 100.0 + kClearance_m + high_m, 0, 0, ground), 0};
    double before_m = over_m(walker.view, ground), seconds = 0.0;
    while (!stands(walker, ground) && seconds < 60.0) {
      walker = walked(walker, {}, 5.0, 1.0 / 60, ground);
      seconds += 1.0 / 60;
      ASSERT_LE(over_m(walker.view, ground), before_m + 1e-6);
      ASSERT_GE(over_m(walker.view, ground), kClearance_m - 1e-6);
      before_m = over_m(walker.view, ground);
    }
    EXPECT_GT(seconds, std::sqrt(2.0 * high_m / 9.81)) << "faster than a stone";
    EXPECT_LT(seconds, std::sqrt(2.0 * high_m / 9.81) + 4.0);
  }
}

TEST(Walk, AStepIsAWayUpAndLateGroundLifts) {
  // A wall of 3 m across the way north.
  const double edge = std::sin(46.0001 * geo::kPi / 180);
  const Ground wall{kEarth.ellipsoid, [&](const geo::Direction& d) { return std::optional(d.n.z > edge ? 3.0 : 0.0); }};
  for (const double back : {1.0, -1.0}) {
    const double lat = 46.0001 - back * 10.0 / 111e3;
    Walker walker{cleared(viewAt(lat, 8, 0, 0, 0, wall), wall), 0};
    double jump_m = 0.0;
    for (int i = 0; i < 400; ++i) {
      const double before_m = height_m(walker.view, wall);
      walker = walked(walker, {.ahead = back}, 5.0, 0.01, wall);
      jump_m = std::max(jump_m, std::abs(height_m(walker.view, wall) - before_m));
      ASSERT_GE(over_m(walker.view, wall), kClearance_m - 1e-6);
    }
    EXPECT_NEAR(height_m(walker.view, wall), (back > 0 ? 3.0 : 0.0) + kClearance_m, 5e-3);
    EXPECT_LT(jump_m, 0.15) << "of 3 m in a hundredth of a second";
  }
  const Walker low{viewAt(46, 8, kClearance_m, 0, 0, level()), 0};
  EXPECT_NEAR(over_m(walked(low, {}, 5.0, 0.0, level(70.0)).view, level(70.0)), kClearance_m, 1e-6);
  EXPECT_NEAR(over_m(walked(low, {}, 5.0, 0.1, level(70.0)).view, level(70.0)), kClearance_m, 1e-6);
}

TEST(Fly, SpeedIsAPartOfTheHeightAboveTheGround) {
  for (const double ground_m : {0.0, 3000.0}) {
    const Ground ground = level(ground_m);
    for (const double high_m : {10.0, 1000.0, 100000.0}) {
      const View start = viewAt(89.9, 8, ground_m + high_m, 0, 0, ground);
      const View level_ = flown(start, {.ahead = 1}, 0.5, 1.0, ground);
      EXPECT_NEAR(geo::length(level_.eye - start.eye) / (0.5 * high_m), 1.0, 1e-3);
      EXPECT_NEAR(over_m(level_, ground), high_m, 1e-6 * high_m + 1e-6);
      const View up = flown(start, {.up = 1}, 0.5, 1.0, ground);
      EXPECT_NEAR(over_m(up, ground) / high_m, std::exp(0.5), 1e-3);
      const View down = flown(viewAt(89.9, 8, ground_m + high_m, 0, -90, ground), {.ahead = 1}, 0.5, 1.0, ground);
      EXPECT_NEAR(over_m(down, ground) / high_m, std::exp(-0.5), 1e-3);
    }
    const View low = flown(viewAt(46, 8, ground_m + 10, 0, -60, ground), {.ahead = 1}, 5.0, 20.0, ground);
    EXPECT_NEAR(over_m(low, ground), kClearance_m, 1e-6);
    EXPECT_LE(height_m(flown(low, {.up = 1}, 10.0, 20.0, ground), ground), 20.01 * kEarth.ellipsoid.semiMajorAxis_m());
  }
}

}  // namespace
}  // namespace tellurion::scene
