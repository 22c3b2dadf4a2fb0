#pragma once

#include <optional>

#include "geo/body.h"
#include "geo/vector.h"

namespace tellurion::geo {

/// Where the sun stands over a body.
///
/// utc_s: seconds since 1970-01-01T00:00:00 UTC, leap seconds not counted. The answer is the unit vector from the
/// body's centre to the sun as it is seen from there (with aberration), in the body frame: the sun is in the zenith
/// where the ellipsoid's normal is this vector. Nothing for a body whose motion is not known here (known are the names
/// of bodyByName()), for a time that is not finite, and outside the years 1000 to 3000.
///
/// Errors from 1950 to 2050: under 0.005 degrees on Earth, of which 0.004 are that UT1 is taken for UTC; under 0.02
/// degrees on the Moon and under 0.05 on Mars. Outside of these years Earth's turn is off by what UT1 has drifted.
///
/// Sources: Earth's and the planets' places are those of VSOP and Simon et al. (1994), the Moon's that of Meeus (1998),
/// all as the ERFA library has them; how bodies are turned stands in body_turn.h.
std::optional<Vec3> directionToSun(const Body& body, double utc_s);

/// Where the Moon is: metres from the Earth's centre in its body frame. utc_s as above, and the same sources; within
/// 0.01 degrees from 1950 to 2050. Nothing outside the years 1000 to 3000.
std::optional<Vec3> moonOverEarth_m(double utc_s);

}  // namespace tellurion::geo
