#include "geo/body_turn.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/angle.h"
#include "geo/sun.h"

namespace tellurion::geo {
namespace {

/// Seconds since 1970 of a Julian day.
double utcOf(double julianDay) {
  return (julianDay - 2440587.5) * 86400.0;
}

Vec3 onSky(double rightAscension_deg, double declination_deg) {
  const SinCos ra = sinCosDegrees(rightAscension_deg), dec = sinCosDegrees(declination_deg);
  return {dec.cos * ra.cos, dec.cos * ra.sin, dec.sin};
}

double apart_deg(const Vec3& a, const Vec3& b) {
  return Angle::radians(std::atan2(length(cross(a, b)), dot(a, b))).degrees();
}

/// Where a place of the sky, told by the equator and equinox of the date, stands over the Earth. Mean sidereal time at
/// Greenwich: Meeus, Astronomical Algorithms (1998), formula 12.4; the apparent one is within 0.005 degrees of it.
Vec3 overEarth(double rightAscension_deg, double declination_deg, double julianDay) {
  const double days = julianDay - 2451545.0, t = days / 36525.0;
  const double sidereal_deg = 280.46061837 + 360.98564736629 * days + 0.000387933 * t * t;
  return onSky(std::remainder(rightAscension_deg - sidereal_deg, 360.0), declination_deg);
}

TEST(BodyTurn, PutsAStarOverTheEarthWhereMeeusSays) {
  // Example 23.a: theta Persei, catalogue and apparent place of 2028 November 13.19 TD.
  const double julianDay = 2462088.69;
  const auto turn = bodyFromCelestial(earth(), utcOf(julianDay - 69.2 / 86400.0));
  ASSERT_TRUE(turn);
  const Vec3 catalogued = onSky(15.0 * (2.0 + 44.0 / 60.0 + 11.986 / 3600.0), 49.0 + 13.0 / 60.0 + 42.48 / 3600.0);
  EXPECT_LT(apart_deg(*turn * catalogued, overEarth(41.5599, 49.3520, julianDay - 69.2 / 86400.0)), 0.02);
  EXPECT_GT(apart_deg(catalogued, overEarth(41.5599, 49.3520, julianDay)), 1.0);
}

TEST(BodyTurn, IsARotation) {
  for (const Body& body : {earth(), mars(), moon()}) {
    const auto turn = bodyFromCelestial(body, utcOf(2460000.5));
    ASSERT_TRUE(turn) << body.name;
    const Mat3 square = glm::transpose(*turn) * *turn;
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(length(square[i] - Mat3(1.0)[i]), 0.0, 1e-14) << body.name;
    EXPECT_NEAR(glm::determinant(*turn), 1.0, 1e-14) << body.name;
  }
}

TEST(BodyTurn, IsKnownForKnownBodiesAndTimesOnly) {
  Body invented = earth();
  invented.name = "arrakis";
  EXPECT_FALSE(bodyFromCelestial(invented, 0.0));
  EXPECT_FALSE(bodyFromCelestial(earth(), std::nan("")));
  EXPECT_FALSE(bodyFromCelestial(earth(), 1e12));
}

TEST(MoonOverEarth, StandsWhereMeeusSays) {
  // Example 47.a: apparent place of 1992 April 12, 0 h TD, 58.3 s later than UT then.
  const double julianDay = 2448724.5 - 58.3 / 86400.0;
  const auto moon_m = moonOverEarth_m(utcOf(julianDay));
  ASSERT_TRUE(moon_m);
  EXPECT_NEAR(length(*moon_m), 368409.7e3, 20e3);
  EXPECT_LT(apart_deg(*moon_m, overEarth(134.688470, 13.768368, julianDay)), 0.01);
  EXPECT_FALSE(moonOverEarth_m(HUGE_VAL));
}

}  // namespace
}  // namespace tellurion::geo
