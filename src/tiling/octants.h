#pragma once

// Inside the room: longitudes counted in octants (units of 45 degrees), where the borders of all tilings are whole
// numbers and dyadic coordinates stay exact until the one call of sine and cosine.

#include "geo/angle.h"

namespace tellurion::tiling {

inline constexpr double kRadiansPerOctant = geo::kPi / 4.0;

/// Sine and cosine of `octants` * 45 degrees, |octants| < 1e9. Exact at whole quarter turns; the same to the last bit
/// for arguments >= 0 that are a whole turn (8) apart, if they are exact. No negative zeros. NaN in, NaN out.
geo::SinCos sinCosOctants(double octants);

/// Longitude of a vector in octants, [-4, 4]: 0 on the axis, +4 rather than -4 on the date line.
double octantsOf(double y, double x);

}  // namespace tellurion::tiling
