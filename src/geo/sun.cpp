#include "geo/sun.h"

#include <erfa.h>
#include <erfam.h>

#include <array>
#include <cmath>

#include "geo/angle.h"

namespace tellurion::geo {
namespace {

constexpr double kUnixEpoch_jd = 2440587.5;
constexpr double kDay_s = 86400.0;
constexpr double kCentury_days = 36525.0;
constexpr double kSpeedOfLight_auPerDay = ERFA_DC;
constexpr double kYear_s = 365.25 * kDay_s;
constexpr double kFirst_s = (1000.0 - 1970.0) * kYear_s;
constexpr double kLast_s = (3000.0 - 1970.0) * kYear_s;

/// A Julian date in two parts, as ERFA wants it for its precision.
struct JulianDate {
  double day = 0.0;
  double rest = 0.0;
};

struct Instant {
  JulianDate ut1;
  JulianDate tt;  ///< also taken for TDB: they differ by less than 2 ms

  double daysSinceJ2000() const { return (tt.day - ERFA_DJ00) + tt.rest; }
};

Instant instantAt(double utc_s) {
  Instant out;
  const JulianDate utc{kUnixEpoch_jd, utc_s / kDay_s};
  out.ut1 = utc;
  JulianDate tai;
  // Their answers say no more than that a date is before leap seconds were or after the last one known.
  eraUtctai(utc.day, utc.rest, &tai.day, &tai.rest);
  eraTaitt(tai.day, tai.rest, &out.tt.day, &out.tt.rest);
  return out;
}

/// Place and motion of a body as the sun sees it, equator and equinox of J2000, in astronomical units and days.
struct Orbit {
  Vec3 place{0.0};
  Vec3 speed{0.0};
};

Orbit orbitOf(const double pv[2][3]) {
  return {{pv[0][0], pv[0][1], pv[0][2]}, {pv[1][0], pv[1][1], pv[1][2]}};
}

Orbit earthAt(const Instant& at) {
  double heliocentric[2][3], barycentric[2][3];
  eraEpv00(at.tt.day, at.tt.rest, heliocentric, barycentric);
  return orbitOf(heliocentric);
}

Orbit moonAt(const Instant& at) {
  double geocentric[2][3];
  eraMoon98(at.tt.day, at.tt.rest, geocentric);
  const Orbit earth = earthAt(at), moon = orbitOf(geocentric);
  return {earth.place + moon.place, earth.speed + moon.speed};
}

Orbit marsAt(const Instant& at) {
  constexpr int kMars = 4;
  double heliocentric[2][3];
  eraPlan94(at.tt.day, at.tt.rest, kMars, heliocentric);
  return orbitOf(heliocentric);
}

/// Aberration to the first order in v/c; the second is below 0.001 arc seconds.
Vec3 apparentSun(const Orbit& body) {
  return normalize(normalize(-body.place) + body.speed / kSpeedOfLight_auPerDay);
}

/// From the equator of J2000 to a frame whose pole and prime meridian are given as the IAU's reports do: right
/// ascension and declination of the pole, and the meridian's angle W from the node of both equators.
Vec3 inBodyFrame(const Vec3& v, Angle poleRightAscension, Angle poleDeclination, Angle primeMeridian) {
  double turn[3][3];
  eraIr(turn);
  eraRz(Angle::degrees(90.0).radians() + poleRightAscension.radians(), turn);
  eraRx(Angle::degrees(90.0).radians() - poleDeclination.radians(), turn);
  eraRz(primeMeridian.radians(), turn);
  double from[3] = {v.x, v.y, v.z}, to[3];
  eraRxp(turn, from, to);
  return {to[0], to[1], to[2]};
}

Vec3 sunOverEarth(const Instant& at) {
  double turn[3][3];
  eraC2t06a(at.tt.day, at.tt.rest, at.ut1.day, at.ut1.rest, 0.0, 0.0, turn);
  const Vec3 sun = apparentSun(earthAt(at));
  double from[3] = {sun.x, sun.y, sun.z}, to[3];
  eraRxp(turn, from, to);
  return {to[0], to[1], to[2]};
}

Vec3 sunOverMars(const Instant& at) {
  const double days = at.daysSinceJ2000(), centuries = days / kCentury_days;
  return inBodyFrame(apparentSun(marsAt(at)), Angle::degrees(317.68143 - 0.1061 * centuries),
                     Angle::degrees(52.88650 - 0.0609 * centuries),
                     Angle::degrees(std::fmod(176.630 + 350.89198226 * days, 360.0)));
}

/// A term of the Moon's rotation: an angle that runs with time, and how far the pole and the meridian follow it.
struct Libration {
  double start_deg, rate_degPerDay;
  double rightAscension_deg, declination_deg, meridian_deg;  ///< of its sine, cosine, sine
};

constexpr std::array<Libration, 13> kMoonLibrations = {{
    {125.045, -0.0529921, -3.8787, 1.5419, 3.5610},
    {250.089, -0.1059842, -0.1204, 0.0239, 0.1208},
    {260.008, 13.0120009, 0.0700, -0.0278, -0.0642},
    {176.625, 13.3407154, -0.0172, 0.0068, 0.0158},
    {357.529, 0.9856003, 0.0, 0.0, 0.0252},
    {311.589, 26.4057084, 0.0072, -0.0029, -0.0066},
    {134.963, 13.0649930, 0.0, 0.0009, -0.0047},
    {276.617, 0.3287146, 0.0, 0.0, -0.0046},
    {34.226, 1.7484877, 0.0, 0.0, 0.0028},
    {15.134, -0.1589763, -0.0052, 0.0008, 0.0052},
    {119.743, 0.0036096, 0.0, 0.0, 0.0040},
    {239.961, 0.1643573, 0.0, 0.0, 0.0019},
    {25.053, 12.9590088, 0.0043, -0.0009, -0.0044},
}};

Vec3 sunOverMoon(const Instant& at) {
  const double days = at.daysSinceJ2000(), centuries = days / kCentury_days;
  double rightAscension_deg = 269.9949 + 0.0031 * centuries;
  double declination_deg = 66.5392 + 0.0130 * centuries;
  double meridian_deg = 38.3213 + 13.17635815 * days - 1.4e-12 * days * days;
  for (const Libration& term : kMoonLibrations) {
    const SinCos angle = sinCosDegrees(term.start_deg + term.rate_degPerDay * days);
    rightAscension_deg += term.rightAscension_deg * angle.sin;
    declination_deg += term.declination_deg * angle.cos;
    meridian_deg += term.meridian_deg * angle.sin;
  }
  return inBodyFrame(apparentSun(moonAt(at)), Angle::degrees(rightAscension_deg), Angle::degrees(declination_deg),
                     Angle::degrees(std::fmod(meridian_deg, 360.0)));
}

}  // namespace

std::optional<Vec3> directionToSun(const Body& body, double utc_s) {
  if (!(utc_s >= kFirst_s && utc_s <= kLast_s)) return std::nullopt;
  const Instant at = instantAt(utc_s);
  if (body.name == "earth") return sunOverEarth(at);
  if (body.name == "mars") return sunOverMars(at);
  if (body.name == "moon") return sunOverMoon(at);
  return std::nullopt;
}

}  // namespace tellurion::geo
