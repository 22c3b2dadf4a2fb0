#include "scene/flight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "geo/body.h"
#include "scene/coast.h"
#include "scene/navigation.h"

namespace tellurion::scene {
namespace {

using geo::Angle;

constexpr double kHalfFov_rad = 22.5 * geo::kPi / 180.0;

Ground hills(const geo::Body& body) {
  const double size_m = 1e-3 * body.ellipsoid.semiMajorAxis_m();
  return {body.ellipsoid, [size_m](const geo::Direction& d) -> std::optional<double> {
            return size_m * std::sin(9.0 * d.n.x + 4.0 * d.n.y) * std::cos(7.0 * d.n.z);
          }};
}

double angleBetween(const View& a, const View& b) {
  const geo::Mat3 r = a.viewFromBody * glm::transpose(b.viewFromBody);
  const geo::Vec3 twice(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
  return std::atan2(geo::length(twice) / 2.0, (r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0);
}

double overGround_m(const View& view, const Ground& ground) {
  return ground.ellipsoid.geodeticFromBody(view.eye).height_m -
         ground.heightOrZero_m(ground.ellipsoid.directionFromBody(view.eye));
}

struct FlightWorld {
  std::string name;
  geo::Body body;
};

class Flights : public testing::TestWithParam<FlightWorld> {
 protected:
  const unsigned seed = 20261123;
  std::mt19937 random{seed};
  const Ground ground = hills(GetParam().body);

  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random); }
  View viewAt(double lat, double lon, double over_m, double heading, double pitch) {
    const auto place = geo::directionFromDegrees(lat, lon);
    const Camera camera{.position = {.lat = Angle::degrees(lat),
                                     .lon = Angle::degrees(lon),
                                     .height_m = ground.heightOrZero_m(place) + over_m},
                        .heading = Angle::degrees(heading),
                        .pitch = Angle::degrees(pitch),
                        .roll = {}};
    return viewOf(camera, ground.ellipsoid, Angle::radians(2.0 * kHalfFov_rad), {1024, 768});
  }
  /// Every fourth near a pole.
  View any() {
    const double lat = between(0, 4) < 1 ? (between(-1, 1) < 0 ? -1 : 1) * (90 - std::pow(10.0, between(-5, 1)))
                                         : std::asin(between(-1, 1)) * 180 / geo::kPi;
    const double over_m = ground.ellipsoid.semiMajorAxis_m() * std::pow(10.0, between(-5, 0.7)) + kClearance_m;
    return viewAt(lat, between(-180, 180), over_m, between(-180, 180), between(-90, 5));
  }
};

TEST_P(Flights, BeginAndEndWhereAsked) {
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View a = any(), b = any();
    const Flight flight(a, b, ground);
    ASSERT_GT(flight.duration_s(), 0.0);
    EXPECT_LE(flight.duration_s(), 10.0);
    // Also by what it computes, not only by what it was given.
    for (const auto& [when, end] : {std::pair(1e-4, a), std::pair(flight.duration_s() - 1e-4, b)}) {
      const View near = flight.at(when);
      EXPECT_LT(geo::length(near.eye - end.eye), 1e-5 * std::max(overGround_m(end, ground), 1.0));
      EXPECT_LT(angleBetween(near, end), 1e-5);
    }
    EXPECT_EQ(flight.at(flight.duration_s()).eye, b.eye);
    EXPECT_EQ(flight.at(flight.duration_s() + 5.0).viewFromBody, b.viewFromBody);
    EXPECT_EQ(flight.at(0.0).eye, a.eye);
  }
}

// Never a jerk: in a hundredth of the time what is seen moves by no more than a share of the picture.
TEST_P(Flights, AreSmoothUprightAndAboveTheGround) {
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View a = any(), b = any();
    const Flight flight(a, b, ground);
    View last = a;
    for (int k = 1; k <= 400; ++k) {
      const View raw = flight.at(flight.duration_s() * k / 400);
      const View now = cleared(raw, ground);
      EXPECT_GE(overGround_m(now, ground), kClearance_m - 1e-5);
      EXPECT_NEAR(poseOf(now, ground.ellipsoid).roll.degrees(), 0.0, 1e-5);
      const double seen_m = std::max(std::min(overGround_m(raw, ground), overGround_m(last, ground)), 100.0);
      EXPECT_LT(geo::length(raw.eye - last.eye) / seen_m, 0.5) << "step " << k;
      EXPECT_LT(angleBetween(raw, last), 0.15) << "step " << k;
      last = raw;
    }
  }
}

TEST_P(Flights, RiseWithTheWayAndComeDownAgain) {
  const double radius_m = ground.ellipsoid.semiMajorAxis_m();
  double lastHighest_m = 0.0;
  for (const double way_degrees : {0.01, 0.1, 1.0, 10.0, 100.0}) {
    const double over_m = 1e-5 * radius_m;
    const Flight flight(viewAt(10, 20, over_m, 0, -90), viewAt(10, 20 + way_degrees, over_m, 0, -90), ground);
    double highest_m = 0.0;
    bool falls = false;
    double before_m = over_m;
    for (int k = 1; k <= 200; ++k) {
      const View view = flight.at(flight.duration_s() * k / 200);
      // Above the straight line between the two grounds, which is what the paper's plane is.
      const double share = (ground.ellipsoid.geodeticFromBody(view.eye).lon.degrees() - 20.0) / way_degrees;
      const double line_m = std::lerp(ground.heightOrZero_m(geo::directionFromDegrees(10, 20)),
                                      ground.heightOrZero_m(geo::directionFromDegrees(10, 20 + way_degrees)),
                                      std::clamp(share, 0.0, 1.0));
      const double now_m = ground.ellipsoid.geodeticFromBody(view.eye).height_m - line_m;
      const double tremble_m = 1e-3 * now_m + 1e-6 * radius_m;
      if (now_m < before_m - tremble_m) falls = true;
      EXPECT_TRUE(!falls || now_m <= before_m + tremble_m) << "rises again at step " << k << " of " << way_degrees;
      before_m = now_m;
      highest_m = std::max(highest_m, now_m);
    }
    EXPECT_GT(highest_m, lastHighest_m);
    EXPECT_LT(highest_m, 19.1 * radius_m);
    lastHighest_m = highest_m;
  }
  EXPECT_GT(lastHighest_m, radius_m) << "half around the body is flown in sight of it all";
}

TEST_P(Flights, TurnTheShorterWayAndKeepNorth) {
  const double over_m = 1e-3 * ground.ellipsoid.semiMajorAxis_m();
  const Flight turn(viewAt(10, 20, over_m, 170, -30), viewAt(12, 24, over_m, -170, -30), ground);
  for (int k = 0; k <= 100; ++k) {
    const double heading = headingOf(poseOf(turn.at(turn.duration_s() * k / 100), ground.ellipsoid)).degrees();
    EXPECT_GE(std::abs(heading), 170.0 - 1e-6);
  }
  const Flight level(viewAt(30, 0, over_m, 0, -60), viewAt(36, 60, over_m, 0, -60), ground);
  for (int k = 0; k <= 100; ++k)
    EXPECT_NEAR(headingOf(poseOf(level.at(level.duration_s() * k / 100), ground.ellipsoid)).degrees(), 0.0, 1e-6);
}

TEST_P(Flights, ToTheSameViewTakeNoTime) {
  const View view = any();
  EXPECT_EQ(Flight(view, view, ground).duration_s(), 0.0);
}

TEST_P(Flights, ToTheOtherSideOfTheBodyArrive) {
  const View a = viewAt(0, 0, 1000, 30, -90), b = viewAt(0, 180, 1000, 30, -90);
  const Flight flight(a, b, ground);
  const View near = flight.at(flight.duration_s() - 1e-4);
  EXPECT_LT(geo::length(near.eye - b.eye), 1.0);
}

// What a drag leaves behind: it goes on as fast as it went, ever slower, and ends.
TEST_P(Flights, CoastingGoesOnFromTheDragAndEnds) {
  for (int i = 0; i < 100; ++i) {
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", case " << i);
    const View start = any();
    const geo::Vec3 axis = geo::normalize(geo::Vec3(between(-1, 1), between(-1, 1), between(-1, 1)));
    const geo::Vec3 turn = axis * (0.3 * overGround_m(start, ground) / ground.ellipsoid.semiMajorAxis_m());
    const double first_m = wayBetween(start, coasted(start, turn, 0.01, ground)) * geo::length(start.eye.m);
    EXPECT_LE(first_m, 1.02 * 0.01 * geo::length(turn) * geo::length(start.eye.m) + kClearance_m);
    View last = start;
    double step_m = 1e300;
    for (int k = 1; k <= 20; ++k) {
      const View now = coasted(start, turn, kCoast_s * k / 20, ground);
      EXPECT_GE(overGround_m(now, ground), kClearance_m - 1e-5);
      const double moved_m = wayBetween(last, now) * ground.ellipsoid.semiMajorAxis_m();
      EXPECT_LE(moved_m, step_m * (1.0 + 1e-6) + 1e-6);
      step_m = moved_m;
      last = now;
    }
    EXPECT_EQ(coasted(start, turn, kCoast_s, ground).eye, coasted(start, turn, kCoast_s + 1.0, ground).eye);
  }
}

INSTANTIATE_TEST_SUITE_P(Bodies, Flights,
                         testing::Values(FlightWorld{"Earth", geo::earth()}, FlightWorld{"Mars", geo::mars()},
                                         FlightWorld{"Moon", geo::moon()},
                                         FlightWorld{"Flat", {"flat", geo::Ellipsoid(5e5, 0.3)}}),
                         [](const auto& world) { return world.param.name; });

TEST(HandSpeed, IsThatOfTheLastMomentsAndNothingAfterAPause) {
  HandSpeed hand;
  for (int i = 0; i <= 20; ++i)
    hand.add({100.0 + 5.0 * i, 50.0 - 2.0 * i}, 0.01 * i);
  const geo::Vec2 fast = hand.at(0.2);
  EXPECT_NEAR(fast.x, 500.0, 1e-6);
  EXPECT_NEAR(fast.y, -200.0, 1e-6);
  EXPECT_EQ(hand.at(0.35), geo::Vec2(0.0)) << "the hand rested before it let go";
  hand.forget();
  hand.add({0.0, 0.0}, 1.0);
  EXPECT_EQ(hand.at(1.0), geo::Vec2(0.0));
}

TEST(HandSpeed, AFlickAfterAPauseHasItsSpeed) {
  for (const double spacing_s : {0.001, 0.004, 0.016, 0.03}) {
    HandSpeed hand;
    hand.add({0.0, 0.0}, 0.0);
    double last_s = 1.0;
    for (double t = 0.0; t < 0.08; t += spacing_s)
      hand.add({1000.0 * t, 0.0}, last_s = 1.0 + t);
    EXPECT_NEAR(hand.at(last_s + 0.05).x, 1000.0, 1.0) << spacing_s;
    EXPECT_EQ(hand.at(last_s + 0.11), geo::Vec2(0.0)) << spacing_s;
  }
  HandSpeed once;  // seen as a single move
  once.add({0.0, 0.0}, 0.0);
  once.add({50.0, 0.0}, 1.0);
  EXPECT_GT(once.at(1.0).x, 100.0);
}

}  // namespace
}  // namespace tellurion::scene
