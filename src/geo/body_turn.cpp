#include "geo/body_turn.h"

#include <erfa.h>

#include <array>
#include <cmath>

#include "geo/angle.h"

namespace tellurion::geo {
namespace {

constexpr double kCentury_days = 36525.0;

/// ERFA's matrices are rows of what they take a column to.
Mat3 matrixOf(const double turn[3][3]) {
  Mat3 out;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      out[column][row] = turn[row][column];
  }
  return out;
}

/// To a frame whose pole and prime meridian are given as the IAU's reports do: right ascension and declination of the
/// pole, and the meridian's angle W from the node of both equators.
Mat3 turnOf(Angle poleRightAscension, Angle poleDeclination, Angle primeMeridian) {
  double turn[3][3];
  eraIr(turn);
  eraRz(Angle::degrees(90.0).radians() + poleRightAscension.radians(), turn);
  eraRx(Angle::degrees(90.0).radians() - poleDeclination.radians(), turn);
  eraRz(primeMeridian.radians(), turn);
  return matrixOf(turn);
}

Mat3 turnOfEarth(const Instant& at) {
  double turn[3][3];
  eraC2t06a(at.tt.day, at.tt.rest, at.ut1.day, at.ut1.rest, 0.0, 0.0, turn);
  return matrixOf(turn);
}

Mat3 turnOfMars(const Instant& at) {
  const double days = at.daysSinceJ2000(), centuries = days / kCentury_days;
  return turnOf(Angle::degrees(317.68143 - 0.1061 * centuries), Angle::degrees(52.88650 - 0.0609 * centuries),
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

Mat3 turnOfMoon(const Instant& at) {
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
  return turnOf(Angle::degrees(rightAscension_deg), Angle::degrees(declination_deg),
                Angle::degrees(std::fmod(meridian_deg, 360.0)));
}

}  // namespace

std::optional<Mat3> bodyFromCelestial(const Body& body, const Instant& at) {
  if (body.name == "earth") return turnOfEarth(at);
  if (body.name == "mars") return turnOfMars(at);
  if (body.name == "moon") return turnOfMoon(at);
  return std::nullopt;
}

std::optional<Mat3> bodyFromCelestial(const Body& body, double utc_s) {
  const auto at = instantAt(utc_s);
  return at ? bodyFromCelestial(body, *at) : std::nullopt;
}

}  // namespace tellurion::geo
