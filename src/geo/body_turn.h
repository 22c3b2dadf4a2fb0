#pragma once

#include <optional>

#include "geo/body.h"
#include "geo/instant.h"
#include "geo/vector.h"

namespace tellurion::geo {

/// How a body is turned among the stars: the rotation from the celestial frame (ICRS; for all but Earth taken for the
/// equator and equinox of J2000, 0.02 arc seconds beside it) to the body frame. Nothing for a body whose motion is not
/// known here: known are earth, mars and moon (bodyByName()).
///
/// Sources: Earth's precession, nutation and turn are those of the IAU 2006/2000A models, as the ERFA library has them;
/// poles and prime meridians of Mars and Moon: Archinal et al., Report of the IAU Working Group on Cartographic
/// Coordinates and Rotational Elements: 2009 (2011), tables 1 and 2. Earth is off by 0.004 degrees at most, since UTC
/// is taken for UT1.
std::optional<Mat3> bodyFromCelestial(const Body& body, const Instant& at);

/// The same at a time, as instantAt() takes it.
std::optional<Mat3> bodyFromCelestial(const Body& body, double utc_s);

}  // namespace tellurion::geo
