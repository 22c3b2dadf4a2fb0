#include "geo/sun.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "geo/angle.h"

namespace tellurion::geo {
namespace {

double utc(int year, unsigned month, unsigned day, double hours = 0.0) {
  const std::chrono::sys_days date = std::chrono::year(year) / std::chrono::month(month) / std::chrono::day(day);
  return static_cast<double>(std::chrono::duration_cast<std::chrono::seconds>(date.time_since_epoch()).count()) +
         3600.0 * hours;
}

struct SubsolarPoint {
  double latitude_deg, longitude_deg;  ///< east
};

SubsolarPoint subsolar(const Body& body, double utc_s) {
  const Vec3 sun = directionToSun(body, utc_s).value();
  EXPECT_NEAR(length(sun), 1.0, 1e-12);
  return {Angle::radians(std::asin(sun.z)).degrees(), Angle::radians(std::atan2(sun.y, sun.x)).degrees()};
}

double apart(double a_deg, double b_deg) {
  return std::abs(std::remainder(a_deg - b_deg, 360.0));
}

/// Degrees, minutes and seconds of arc, as almanacs print them.
struct Arc {
  int degrees, minutes;
  double seconds;
  double value() const { return degrees + minutes / 60.0 + seconds / 3600.0; }
};

struct AlmanacDay {
  int year;
  unsigned month, day;
  double sign;  ///< of the declination
  Arc declination, greenwichHourAngle;
};

// Sun and Polaris Ephemeris of the cadastral surveyors' almanac, 0 h UT (cadastral.com/1999jan.htm and its fellows).
constexpr AlmanacDay kAlmanac[] = {
    {1999, 1, 1, -1, {23, 3, 9.3}, {179, 12, 41.8}},    {1999, 1, 5, -1, {22, 40, 57.1}, {178, 44, 57.4}},
    {1999, 1, 9, -1, {22, 11, 33.5}, {178, 18, 50.0}},  {1999, 1, 13, -1, {21, 35, 12.1}, {177, 54, 43.9}},
    {1999, 1, 17, -1, {20, 52, 9.6}, {177, 33, 2.0}},   {1999, 1, 20, -1, {20, 15, 41.2}, {177, 18, 33.2}},
    {1999, 8, 1, 1, {18, 10, 51.9}, {178, 24, 39.3}},   {1999, 8, 4, 1, {17, 24, 51.5}, {178, 27, 47.4}},
    {1999, 8, 8, 1, {16, 19, 34.1}, {178, 34, 0.4}},    {1999, 8, 12, 1, {15, 10, 4.0}, {178, 42, 31.2}},
    {1999, 8, 16, 1, {13, 56, 41.6}, {178, 53, 17.7}},  {1999, 8, 20, 1, {12, 39, 47.1}, {179, 6, 14.4}},
    {1999, 9, 1, 1, {8, 31, 15.9}, {179, 56, 4.5}},     {1999, 9, 5, 1, {7, 3, 35.1}, {180, 15, 25.3}},
    {1999, 9, 9, 1, {5, 34, 2.6}, {180, 35, 39.7}},     {1999, 9, 13, 1, {4, 3, 0.2}, {180, 56, 33.2}},
    {1999, 9, 17, 1, {2, 30, 49.6}, {181, 17, 50.6}},   {1999, 9, 21, 1, {0, 57, 52.8}, {181, 39, 14.4}},
    {2013, 1, 1, -1, {23, 0, 8.9}, {179, 8, 29.6}},     {2013, 1, 5, -1, {22, 36, 49.7}, {178, 40, 55.0}},
    {2013, 1, 9, -1, {22, 6, 20.1}, {178, 14, 59.5}},   {2013, 1, 13, -1, {21, 28, 54.9}, {177, 51, 10.0}},
    {2013, 1, 17, -1, {20, 44, 52.3}, {177, 29, 53.0}}, {2013, 1, 20, -1, {20, 7, 41.5}, {177, 15, 47.9}},
};

TEST(Sun, StandsOverEarthWhereTheAlmanacSays) {
  for (const AlmanacDay& day : kAlmanac) {
    const SubsolarPoint sun = subsolar(earth(), utc(day.year, day.month, day.day));
    // The almanac's own last digit is 0.00003 degrees.
    EXPECT_NEAR(sun.latitude_deg, day.sign * day.declination.value(), 0.001)
        << day.year << '-' << day.month << '-' << day.day;
    EXPECT_LT(apart(sun.longitude_deg, -day.greenwichHourAngle.value()), 0.001)
        << day.year << '-' << day.month << '-' << day.day;
  }
}

/// The recipe of Allison and McEwen, A post-Pathfinder evaluation of areocentric solar coordinates with improved timing
/// recipes for Mars seasonal/diurnal climate studies (Planetary and Space Science 48, 2000), table 5 with the
/// corrections of Mars24's notes: series in the mean anomaly, made without an ephemeris.
SubsolarPoint marsByRecipe(double utc_s, double ttMinusUtc_s) {
  const double days = (utc_s + ttMinusUtc_s) / 86400.0 - 10957.5;  // since J2000 (TT)
  const auto sine = [](double degrees) { return std::sin(Angle::degrees(degrees).radians()); };
  const double meanAnomaly = 19.3871 + 0.52402073 * days;
  const double meanSun = 270.3871 + 0.524038496 * days;
  struct Perturber {
    double size, period_years, phase_deg;
  };
  constexpr Perturber kPerturbers[] = {{0.0071, 2.2353, 49.409},  {0.0057, 2.7543, 168.173}, {0.0039, 1.1177, 191.837},
                                       {0.0037, 15.7866, 21.736}, {0.0021, 2.1354, 15.704},  {0.0020, 2.4694, 95.528},
                                       {0.0018, 32.8493, 49.095}};
  double perturbations = 0.0;
  for (const Perturber& p : kPerturbers)
    perturbations += p.size * sine(0.985626 * days / p.period_years + p.phase_deg + 90.0);
  const double centre = (10.691 + 3.0e-7 * days) * sine(meanAnomaly) + 0.623 * sine(2 * meanAnomaly) +
                        0.050 * sine(3 * meanAnomaly) + 0.005 * sine(4 * meanAnomaly) + 0.0005 * sine(5 * meanAnomaly) +
                        perturbations;
  const double season = meanSun + centre;
  const double equationOfTime = 2.861 * sine(2 * season) - 0.071 * sine(4 * season) + 0.002 * sine(6 * season) - centre;
  const double meanSolarTime_h = 24.0 * ((days - 4.5) / 1.0274912517 + 44796.0 - 0.0009626);
  const double west = 15.0 * meanSolarTime_h + equationOfTime + 180.0;
  return {Angle::radians(std::asin(0.42565 * sine(season))).degrees(), -west};
}

TEST(Sun, StandsOverMarsWhereMars24Says) {
  // The worked examples of Mars24's notes: the sun in the zenith of 174.726 W, and at the landing of MER-A (13:46:31
  // UTC), from its mean solar time 13.16537 h and equation of time -0.85170 h, of 4.705 W.
  EXPECT_LT(apart(subsolar(mars(), utc(2000, 1, 6)).longitude_deg, -174.726), 0.05);
  EXPECT_LT(apart(subsolar(mars(), utc(2004, 1, 3, 13.0 + 46.0 / 60.0 + 31.0 / 3600.0)).longitude_deg, -4.705), 0.05);
}

TEST(Sun, StandsOverMarsWhereTheRecipeSays) {
  std::mt19937 dice(7);
  std::uniform_real_distribution<double> anyTime(utc(1999, 1, 1), utc(2005, 12, 31));  // TT - UTC stood at 64.184 s
  for (int i = 0; i < 400; ++i) {
    const double when = anyTime(dice);
    const SubsolarPoint sun = subsolar(mars(), when), expected = marsByRecipe(when, 64.184);
    EXPECT_NEAR(sun.latitude_deg, expected.latitude_deg, 0.05) << when;
    EXPECT_LT(apart(sun.longitude_deg, expected.longitude_deg), 0.1) << when;
  }
}

TEST(Sun, StandsOverTheMoonWhereMeeusSays) {
  // Meeus, Astronomical Algorithms (1998), example 53.a: 1992 April 12, 0 h TD, 58.3 s later than UT then.
  const SubsolarPoint sun = subsolar(moon(), utc(1992, 4, 12) - 58.3);
  EXPECT_NEAR(sun.latitude_deg, 1.46, 0.02);
  EXPECT_LT(apart(sun.longitude_deg, 67.89), 0.03);
}

TEST(Sun, GoesAroundInADayOfTheBody) {
  // Mean solar days in hours; a day of the Moon is the mean synodic month.
  struct Day {
    Body body;
    double hours, slack;  // slack: the days of a year are not equally long
  };
  for (const Day& day : {Day{earth(), 24.0, 0.01}, Day{mars(), 24.6598, 0.01}, Day{moon(), 29.530589 * 24.0, 8.0}}) {
    const double start = utc(2026, 3, 1), hour_s = 3600.0;
    const double first = subsolar(day.body, start).longitude_deg;
    const double turned = std::remainder(subsolar(day.body, start + hour_s * day.hours).longitude_deg - first, 360.0);
    EXPECT_LT(std::abs(turned) / 360.0 * day.hours, day.slack) << day.body.name;
    // Westwards, a little further every hour.
    EXPECT_LT(std::remainder(subsolar(day.body, start + hour_s).longitude_deg - first, 360.0), 0.0) << day.body.name;
  }
}

TEST(Sun, IsKnownForKnownBodiesAndTimesOnly) {
  Body invented = earth();
  invented.name = "arrakis";
  EXPECT_FALSE(directionToSun(invented, 0.0));
  EXPECT_TRUE(directionToSun(earth(), utc(1066, 10, 14)));
  EXPECT_FALSE(directionToSun(earth(), utc(999, 1, 1)));
  EXPECT_FALSE(directionToSun(earth(), utc(3001, 1, 1)));
  EXPECT_FALSE(directionToSun(earth(), std::nan("")));
  EXPECT_FALSE(directionToSun(earth(), HUGE_VAL));
}

}  // namespace
}  // namespace tellurion::geo
