#pragma once

#include <string_view>

#include "scene/camera.h"

namespace tellurion::scene {

/// A place as a person wrote it.
struct WrittenPlace {
  Camera camera;             ///< straight down to the north, where nothing else was written
  bool hasHeight = false;    ///< else the height is 0 and means nothing
  bool hasAttitude = false;  ///< heading, pitch and roll were written
};

/// Coordinates in the common notations, latitude first unless letters say otherwise:
///   27.98812, 86.92505        27.98812 86.92505       -33.85, 151.2
///   27° 59' 17.2" N 86° 55' 30" E     N 27 59.287, E 86 55.503     27d59m17.2sN 86d55m30sE     27:59:17 86:55:30
///   27 59 17 86 55 30 (degrees, minutes, seconds twice)     27 59.3 86 55.5     E 86.9 N 28     lat 28 lon 86.9
/// Any of them may be followed by a height above the ellipsoid: 8848, 8848 m, 8.8 km, alt 29029 ft. A list of three to
/// six numbers with commas is a camera (parseCamera). A decimal comma is read where commas as separators make no place
/// (48,25; 2,35   48,8566N 2,3522E); where both make one (48,85, 2,35), and for an S that may mean seconds or south
/// (33d51m10s, 151d12m40s E), it fails. Marks for degrees, minutes and seconds may be ASCII or
/// typographic. Latitude within 90 degrees, longitude within 360, minutes and seconds under 60; else, and for whatever
/// cannot be told with certainty, a failure that says what. Safe on any bytes; text beyond 200 bytes is refused.
io::Result<WrittenPlace> parsePlace(std::string_view text);

}  // namespace tellurion::scene
