#pragma once

#include "geo/geodetic.h"

namespace tellurion::geo {

/// A rectangle of latitude and longitude, closed. It may cross the date line: it runs east from `west` over `width`.
/// Filled by name. Covers a pole by reaching latitude +-90.
struct GeoRect {
  Angle south;
  Angle north;
  Angle west;   ///< [-180, 180)
  Angle width;  ///< eastward extent, [0, 360] degrees

  static GeoRect whole();
  static GeoRect fromDegrees(double south, double west, double north, double east);  ///< east < west crosses the date line

  Angle east() const { return west + width; }  ///< may exceed 180 degrees
  bool contains(Angle lat, Angle lon) const;
  bool intersects(const GeoRect& o) const;
  GeoRect united(const GeoRect& o) const;  ///< the smallest that holds both; of two equally small the one that starts at *this
};

}  // namespace tellurion::geo
