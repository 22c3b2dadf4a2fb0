#pragma once

#include "geo/angle.h"
#include "geo/vector.h"

namespace tellurion::geo {

/// A position above a reference ellipsoid. Always filled by name: Geodetic{.lat = ..., .lon = ..., .height_m = ...}.
struct Geodetic {
  Angle lat;              ///< geodetic, positive to the north, [-90, 90] degrees
  Angle lon;              ///< positive to the east
  double height_m = 0.0;  ///< metres above the ellipsoid, along its normal
};

/// A position in the body frame: right-handed Cartesian, metres, origin at the body's centre, z to the north pole,
/// x through latitude 0, longitude 0.
struct BodyPosition {
  Vec3 m{0.0, 0.0, 0.0};

  friend Vec3 operator-(const BodyPosition& a, const BodyPosition& b) { return a.m - b.m; }
  friend BodyPosition operator+(const BodyPosition& a, const Vec3& d) { return {a.m + d}; }
  friend BodyPosition operator-(const BodyPosition& a, const Vec3& d) { return {a.m - d}; }
  friend bool operator==(const BodyPosition&, const BodyPosition&) = default;
};

/// A place on a surface, whatever the body's size: the unit vector, in the body frame, of the ellipsoid's outward
/// normal there (the "n-vector"; its spherical latitude is the geodetic latitude). What tilings speak.
struct Direction {
  Vec3 n{0.0, 0.0, 1.0};

  friend bool operator==(const Direction&, const Direction&) = default;
};

/// Exact at the poles and on the quarter meridians (see sinCosDegrees).
Direction directionFromLatLon(Angle lat, Angle lon);
Direction directionFromDegrees(double lat, double lon);

/// Height is 0. At a pole the longitude is 0.
Geodetic geodeticFromDirection(const Direction& d);

/// The angle between two directions; precise for small and for near-opposite ones.
Angle angleBetween(const Direction& a, const Direction& b);

}  // namespace tellurion::geo
