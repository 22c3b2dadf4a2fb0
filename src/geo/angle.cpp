#include "geo/angle.h"

#include <cmath>

namespace tellurion::geo {

namespace {

constexpr double kHalfPi = kPi / 2.0;
constexpr double kExactTurns = 1e13;  // below it, and well above what any file holds, the reductions here are exact

}  // namespace

SinCos sinCosQuarters(long long quarters, Angle rest) {
  const double s = std::sin(rest.radians());
  const double c = std::cos(rest.radians());
  switch (quarters & 3) {
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

SinCos sinCosDegrees(double degrees) {
  if (!(std::fabs(degrees) < kExactTurns)) degrees = std::remainder(degrees, 360.0);
  if (std::isnan(degrees)) return {degrees, degrees};
  const double quarters = std::nearbyint(degrees / 90.0);
  return sinCosQuarters(static_cast<long long>(quarters), Angle::degrees(degrees - 90.0 * quarters));
}

SinCos sinCos(Angle angle) {
  double radians = angle.radians();
  if (!(std::fabs(radians) < kExactTurns)) radians = std::remainder(radians, 2.0 * kPi);
  if (std::isnan(radians)) return {radians, radians};
  const double quarters = std::nearbyint(radians / kHalfPi);
  return sinCosQuarters(static_cast<long long>(quarters), Angle::radians(radians - kHalfPi * quarters));
}

Angle wrappedLongitude(Angle longitude) {
  const double radians = longitude.radians();
  if (radians >= -kPi && radians < kPi) return longitude;
  const double wrapped = std::remainder(radians, 2.0 * kPi);
  return Angle::radians(wrapped >= kPi ? -kPi : wrapped);
}

}  // namespace tellurion::geo
