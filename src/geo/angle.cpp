#include "geo/angle.h"

#include <cmath>

namespace tellurion::geo {

namespace {

constexpr double kHalfPi = kPi / 2.0;
constexpr double kExactTurns = 1e13;  // below it, and well above what any file holds, the reductions here are exact

// Sine and cosine of quarters * 90 degrees + remainder; remainder is at most 45 degrees. No negative zeros come out.
SinCos rotated(double remainder, double quarters) {
  const double s = std::sin(remainder);
  const double c = std::cos(remainder);
  switch (static_cast<long long>(quarters) & 3) {
    case 0:
      return {s + 0.0, c + 0.0};
    case 1:
      return {c + 0.0, -s + 0.0};
    case 2:
      return {-s + 0.0, -c + 0.0};
    default:
      return {-c + 0.0, s + 0.0};
  }
}

}  // namespace

SinCos sinCosDegrees(double degrees) {
  if (!(std::fabs(degrees) < kExactTurns)) degrees = std::remainder(degrees, 360.0);
  if (std::isnan(degrees)) return {degrees, degrees};
  const double quarters = std::nearbyint(degrees / 90.0);
  return rotated((degrees - 90.0 * quarters) * (kPi / 180.0), quarters);
}

SinCos sinCos(Angle angle) {
  double radians = angle.radians();
  if (!(std::fabs(radians) < kExactTurns)) radians = std::remainder(radians, 2.0 * kPi);
  if (std::isnan(radians)) return {radians, radians};
  const double quarters = std::nearbyint(radians / kHalfPi);
  return rotated(radians - kHalfPi * quarters, quarters);
}

Angle wrappedLongitude(Angle longitude) {
  const double radians = longitude.radians();
  if (radians >= -kPi && radians < kPi) return longitude;
  const double wrapped = std::remainder(radians, 2.0 * kPi);
  return Angle::radians(wrapped >= kPi ? -kPi : wrapped);
}

}  // namespace tellurion::geo
