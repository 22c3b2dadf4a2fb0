#pragma once

#include <optional>

#include "geo/geodetic.h"

namespace tellurion::geo {

/// A half-line in the body frame. `direction` need not be of unit length; distances along it are in its units.
struct Ray {
  BodyPosition origin;
  Vec3 direction;
};

/// A reference ellipsoid of revolution. Immutable, thread-safe, a value.
class Ellipsoid {
 public:
  /// Semi-major (equatorial) axis in metres, > 0; flattening (a - b) / a in [0, 1).
  constexpr Ellipsoid(double semiMajorAxis_m, double flattening) : a_(semiMajorAxis_m), f_(flattening) {}

  constexpr double semiMajorAxis_m() const { return a_; }
  constexpr double semiMinorAxis_m() const { return a_ * (1.0 - f_); }
  constexpr double flattening() const { return f_; }
  constexpr double meanRadius_m() const { return a_ * (1.0 - f_ / 3.0); }

  BodyPosition bodyFromGeodetic(const Geodetic& g) const;
  Geodetic geodeticFromBody(const BodyPosition& p) const;

  /// The point `height_m` above the ellipsoid along the normal `d`. No trigonometry.
  BodyPosition bodyFromDirection(const Direction& d, double height_m = 0.0) const;
  /// The normal of the ellipsoid under (or over) a point.
  Direction directionFromBody(const BodyPosition& p) const;

  /// Where a ray first meets the ellipsoid's outside raised by height_m (semi-axes a + h, b + h): distance along the
  /// ray in units of its direction, >= 0; nothing when it misses. A ray from inside gives its way out.
  std::optional<double> intersect(const Ray& ray, double height_m = 0.0) const;

  /// Whether the point `target` is hidden from `eye` behind the ellipsoid shrunk by `depth_m` on both axes.
  /// Conservative: true only when it is hidden.
  bool isBelowHorizon(const BodyPosition& eye, const BodyPosition& target, double depth_m = 0.0) const;

  /// Distance in metres from a point height_m above the equator-sized sphere to its horizon: sqrt(2 a h + h^2).
  double horizonDistance_m(double height_m) const;

  friend constexpr bool operator==(const Ellipsoid&, const Ellipsoid&) = default;

 private:
  double a_;
  double f_;
};

}  // namespace tellurion::geo
