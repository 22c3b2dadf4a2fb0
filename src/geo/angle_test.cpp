#include "geo/angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geo/seed_test.h"

namespace tellurion::geo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void expectBoth(const SinCos& actual, double sin, double cos) {
  EXPECT_EQ(actual.sin, sin);
  EXPECT_EQ(actual.cos, cos);
  EXPECT_FALSE(actual.sin == 0.0 && std::signbit(actual.sin));
  EXPECT_FALSE(actual.cos == 0.0 && std::signbit(actual.cos));
}

TEST(Angle, DegreesAndRadians) {
  EXPECT_EQ(Angle::degrees(180.0).radians(), kPi);
  EXPECT_EQ(Angle::degrees(90.0).radians(), kPi / 2.0);
  EXPECT_EQ(Angle::degrees(90.0).degrees(), 90.0);
  EXPECT_DOUBLE_EQ(Angle::degrees(12.5).degrees(), 12.5);
  EXPECT_EQ((Angle::degrees(30.0) + Angle::degrees(60.0)) / Angle::degrees(90.0), 1.0);
  EXPECT_LT(-Angle::degrees(1.0), Angle::degrees(1.0));
}

TEST(SinCos, ExactAtQuarterTurns) {
  for (int turn = -3; turn <= 3; ++turn) {
    SCOPED_TRACE(turn);
    expectBoth(sinCosDegrees(360.0 * turn), 0.0, 1.0);
    expectBoth(sinCosDegrees(360.0 * turn + 90.0), 1.0, 0.0);
    expectBoth(sinCosDegrees(360.0 * turn + 180.0), 0.0, -1.0);
    expectBoth(sinCosDegrees(360.0 * turn + 270.0), -1.0, 0.0);
  }
  for (int quarter = -4; quarter <= 4; ++quarter) {
    SCOPED_TRACE(quarter);
    const SinCos expected = sinCosDegrees(90.0 * quarter);
    expectBoth(sinCos(Angle::degrees(90.0 * quarter)), expected.sin, expected.cos);
  }
}

TEST(SinCos, QuartersCountWholeTurnsAway) {
  auto random = seededGenerator();
  for (int i = 0; i < 1000; ++i) {
    const double rest = uniform(random, -45.0, 45.0);
    for (long long quarter = -9; quarter <= 9; ++quarter) {
      const SinCos actual = sinCosQuarters(quarter, Angle::degrees(rest));
      const long double truth = (90.0L * static_cast<long double>(quarter) + static_cast<long double>(rest)) *
                                (3.14159265358979323846264338L / 180.0L);
      EXPECT_NEAR(actual.sin, static_cast<double>(std::sin(truth)), 1.7e-16);
      EXPECT_NEAR(actual.cos, static_cast<double>(std::cos(truth)), 1.7e-16);
    }
  }
}

TEST(SinCos, SameToTheLastBitAWholeTurnApart) {
  for (const double d : {0.125, 12.5, -77.75, 179.5}) {
    for (const double turns : {1.0, -1.0, 7.0, 1e9}) {
      EXPECT_EQ(sinCosDegrees(d + 360.0 * turns).sin, sinCosDegrees(d).sin) << d;
      EXPECT_EQ(sinCosDegrees(d + 360.0 * turns).cos, sinCosDegrees(d).cos) << d;
    }
  }
}

TEST(SinCos, WithinAnUlpOrTwo) {
  auto random = seededGenerator();
  for (int i = 0; i < 200000; ++i) {
    const double degrees = uniform(random, -450.0, 450.0);
    const long double truth = static_cast<long double>(degrees) * (3.14159265358979323846264338L / 180.0L);
    EXPECT_NEAR(sinCosDegrees(degrees).sin, static_cast<double>(std::sin(truth)), 1.7e-16);
    EXPECT_NEAR(sinCosDegrees(degrees).cos, static_cast<double>(std::cos(truth)), 1.7e-16);
    const Angle angle = Angle::radians(static_cast<double>(truth));
    EXPECT_NEAR(sinCos(angle).sin, static_cast<double>(std::sin(static_cast<long double>(angle.radians()))), 6e-16);
    EXPECT_NEAR(sinCos(angle).cos, static_cast<double>(std::cos(static_cast<long double>(angle.radians()))), 6e-16);
  }
}

TEST(SinCos, NanAndInfinity) {
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(std::isnan(sinCosDegrees(bad).sin));
    EXPECT_TRUE(std::isnan(sinCosDegrees(bad).cos));
    EXPECT_TRUE(std::isnan(sinCos(Angle::radians(bad)).sin));
    EXPECT_TRUE(std::isnan(sinCos(Angle::radians(bad)).cos));
  }
  EXPECT_TRUE(std::isfinite(sinCosDegrees(1e300).sin));
}

TEST(WrappedLongitude, IntoTheTurnAroundZero) {
  EXPECT_EQ(wrappedLongitude(Angle::degrees(180.0)).degrees(), -180.0);
  EXPECT_EQ(wrappedLongitude(Angle::degrees(-180.0)).degrees(), -180.0);
  EXPECT_EQ(wrappedLongitude(Angle::degrees(540.0)).degrees(), -180.0);
  EXPECT_NEAR(wrappedLongitude(Angle::degrees(190.0)).degrees(), -170.0, 1e-13);
  EXPECT_NEAR(wrappedLongitude(Angle::degrees(-725.0)).degrees(), -5.0, 1e-12);
  EXPECT_EQ(wrappedLongitude(Angle::degrees(12.3)), Angle::degrees(12.3));
  EXPECT_TRUE(std::isnan(wrappedLongitude(Angle::radians(kNaN)).radians()));
}

}  // namespace
}  // namespace tellurion::geo
