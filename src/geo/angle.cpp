#include "geo/angle.h"

#include <array>
#include <cmath>
#include <cstddef>

namespace tellurion::geo {

namespace {

constexpr double kHalfPi = kPi / 2.0;
constexpr double kExactTurns = 1e13;  // below it, and well above what any file holds, the reductions here are exact

/// To the nearest whole number, of two the even one, for |x| < kExactTurns: what std::nearbyint does by a call.
double nearestWhole(double x) {
  constexpr double kLastWholes = 0x1.8p52;  // doubles near it are the whole numbers
  return (x + kLastWholes) - kLastWholes;
}

}  // namespace

SinCos sinCosDegrees(double degrees) {
  if (!(std::fabs(degrees) < kExactTurns)) degrees = std::remainder(degrees, 360.0);
  if (std::isnan(degrees)) return {degrees, degrees};
  const double quarters = nearestWhole(degrees / 90.0);
  return sinCosQuarters(static_cast<long long>(quarters), Angle::degrees(degrees - 90.0 * quarters));
}

SinCos sinCos(Angle angle) {
  double radians = angle.radians();
  if (!(std::fabs(radians) < kExactTurns)) radians = std::remainder(radians, 2.0 * kPi);
  if (std::isnan(radians)) return {radians, radians};
  const double quarters = nearestWhole(radians / kHalfPi);
  return sinCosQuarters(static_cast<long long>(quarters), Angle::radians(radians - kHalfPi * quarters));
}

Angle wrappedLongitude(Angle longitude) {
  const double radians = longitude.radians();
  if (radians >= -kPi && radians < kPi) return longitude;
  const double wrapped = std::remainder(radians, 2.0 * kPi);
  return Angle::radians(wrapped >= kPi ? -kPi : wrapped);
}

}  // namespace tellurion::geo
