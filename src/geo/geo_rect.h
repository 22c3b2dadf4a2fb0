#pragma once

#include "geo/geodetic.h"

namespace tellurion::geo {

/// A rectangle of latitude and longitude, closed. It may cross the date line: it runs east from `west` over `width`.
/// Filled by name. Covers a pole by reaching latitude +-90; the pole then belongs to it with every longitude.
/// Longitudes given to it may lie in any turn. Nothing contains or intersects NaN.
struct GeoRect {
  /// Edges count as inside up to this, so that rounding of west + width never loses what lies on the edge: 13 nm on
  /// Earth.
  static constexpr double kTolerance_rad = 2e-15;

  Angle south;
  Angle north;
  Angle west;   ///< [-180, 180)
  Angle width;  ///< eastward extent, [0, 360] degrees

  static GeoRect whole();
  /// east < west crosses the date line; east - west >= 360 is the whole circle.
  static GeoRect fromDegrees(double south, double west, double north, double east);

  Angle east() const { return west + width; }  ///< may exceed 180 degrees
  bool contains(Angle lat, Angle lon) const;
  bool intersects(const GeoRect& o) const;
  /// The smallest that holds both; of two equally small the one that starts at this->west.
  GeoRect united(const GeoRect& o) const;
  /// Holds every place that is no farther from this one than `by` (an angle between directions, not negative).
  GeoRect grown(Angle by) const;
};

}  // namespace tellurion::geo
