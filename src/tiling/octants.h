#pragma once

// Inside the room: longitudes counted in octants (units of 45 degrees), where the borders of all tilings are whole
// numbers and dyadic coordinates stay exact until the one call of sine and cosine.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geo/angle.h"

namespace tellurion::tiling {

inline constexpr double kRadiansPerOctant = geo::kPi / 4.0;

/// 1 where a < b, else 0; any of the two for NaN. What cannot be foreseen of a place is better a factor than a branch,
/// and as sums and signs it keeps no loop from being vectorised.
inline double oneIfLess(double a, double b) {
  return 0.5 - std::copysign(0.5, a - b);
}

/// What follows for |octants| < 1e9, not NaN, without looking.
inline geo::SinCos sinCosFewOctants(double octants) {
  const int quarters = static_cast<int>(octants * 0.5 + std::copysign(0.5, octants));
  return geo::sinCosQuarters(quarters, geo::Angle::radians((octants - 2.0 * quarters) * kRadiansPerOctant));
}
/// Sine and cosine of `octants` * 45 degrees, |octants| < 1e9. Exact at whole quarter turns; the same to the last bit
/// for arguments >= 0 that are a whole turn (8) apart, if they are exact. No negative zeros. NaN in, NaN out.
inline geo::SinCos sinCosOctants(double octants) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  if (!(std::fabs(octants) < 1e9)) return {kNaN, kNaN};
  return sinCosFewOctants(octants);
}

/// The angle of tan = r in octants over r, |r| <= tan(22.5 degrees): the polynomial in r^2 whose largest relative error
/// is least, 3.4e-17.
inline double octantsPerTangent(double r2) {
  constexpr std::array<double, 11> k{1.2732395447351625,  -0.4244131815783275,  0.2546479089328897, -0.1818913622322929,
                                     0.1414709989648561,  -0.11574734412658709, 0.0979118778668741, -0.0845489385995139,
                                     0.07244042356455237, -0.05539975526889658, 0.02695535587328569};
  const double r4 = r2 * r2;
  const double r8 = r4 * r4;
  return (((k[0] + r2 * k[1]) + r4 * (k[2] + r2 * k[3])) + r8 * ((k[4] + r2 * k[5]) + r4 * (k[6] + r2 * k[7]))) +
         r8 * (r8 * ((k[8] + r2 * k[9]) + r4 * k[10]));
}

/// Longitude of a vector in octants, [-4, 4]: 0 on the axis, +4 rather than -4 on the date line, whole numbers exact.
/// Within 5e-16 octants. The same bits on every machine. NaN in, NaN out; infinities give NaN.
inline double octantsOf(double y, double x) {
  constexpr double kTangentOfHalfAnOctant = 0.41421356237309503;
  constexpr double kLeast = std::numeric_limits<double>::min();
  const double ax = std::fabs(x);
  const double ay = std::fabs(y);
  const double shorter = std::min(ax, ay);
  const double longer = std::max(ax, ay);
  // Which eighth a place is in cannot be foreseen: numbers, 0 or 1, instead of branches.
  const double nearDiagonal = oneIfLess(longer * kTangentOfHalfAnOctant, shorter);
  const double nearY = oneIfLess(ax, ay);
  const double behind = oneIfLess(x, 0.0);
  // The angle from the nearer axis, by way of that from the axis or from the diagonal.
  const double r = (shorter - nearDiagonal * longer) / std::max(longer + nearDiagonal * shorter, kLeast);
  const double fromAxis = r * octantsPerTangent(r * r) + nearDiagonal;
  const double fromX = 2.0 * nearY + (1.0 - 2.0 * nearY) * fromAxis;
  const double octants = 4.0 * behind + (1.0 - 2.0 * behind) * fromX;
  return std::copysign(octants, y + 0.0) + 0.0 * (x + y);  // a NaN stays one
}

}  // namespace tellurion::tiling
