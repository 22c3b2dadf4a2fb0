#pragma once

#include <limits>
#include <optional>

#include "geo/geodetic.h"

namespace tellurion::geo {

/// A half-line in the body frame. `direction` need not be of unit length; distances along it are in its units.
struct Ray {
  BodyPosition origin;
  Vec3 direction;
};

/// What an ellipsoid hides from an eye. Immutable.
class Horizon {
 public:
  /// True only when the point is hidden, rounding included; false for an eye inside the ellipsoid and for NaN.
  bool hides(const BodyPosition& point) const {
    const Vec3 sight = (point.m - eye_) * scale_;
    const double towards = -dot(from_, sight);
    return towards > tangent2_ && towards * towards > tangent2_ * dot(sight, sight);
  }
  /// How far the point is from being hidden, in units of the ellipsoid's size: below 0 where it is hidden, but for
  /// rounding; continuous, and without meaning beyond that.
  double clearance(const BodyPosition& point) const {
    const Vec3 sight = (point.m - eye_) * scale_;
    const double towards = -dot(from_, sight);
    return std::max(tangent2_, std::sqrt(tangent2_ * dot(sight, sight))) - towards;
  }

 private:
  friend class Ellipsoid;
  Vec3 eye_{0.0};
  Vec3 scale_{0.0};                                            ///< to where the ellipsoid is the unit sphere
  Vec3 from_{0.0};                                             ///< the eye there
  double tangent2_ = std::numeric_limits<double>::infinity();  ///< squared distance to the horizon there, rounded up
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

  /// Any latitude, longitude in any turn, any height. Within 5 nm of GeographicLib up to 1,000 km from Earth's surface,
  /// 6e-16 of the distance from the centre beyond. At a pole exactly on the axis. NaN in, NaN out.
  BodyPosition bodyFromGeodetic(const Geodetic& g) const;

  /// Defined everywhere. Latitude [-90, 90], longitude [-180, 180] degrees, +180 on the date line, 0 on the axis. Of
  /// several places whose normals pass through the point, the nearest; of two equally near the northern; at the centre
  /// the north pole. Errors as above, in all of space: Vermeille's closed form (2011) in long double, see
  /// ellipsoid.cpp. NaN in, NaN out (a NaN z alone leaves the longitude).
  Geodetic geodeticFromBody(const BodyPosition& p) const;

  /// The point `height_m` above the ellipsoid along the normal `d`, a unit vector. One square root, no trigonometry.
  BodyPosition bodyFromDirection(const Direction& d, double height_m = 0.0) const;
  /// The normal of the ellipsoid under (or over) a point; ties and errors as geodeticFromBody.
  Direction directionFromBody(const BodyPosition& p) const;

  /// Where a ray first meets the ellipsoid raised by height_m (semi-axes a + h, b + h): distance along the ray in units
  /// of its direction, >= 0. From on it 0, from inside the way out. Nothing when it misses, when its direction is zero,
  /// when an axis would not be positive, and for NaN. Well-conditioned for grazing and for far rays: about 1e-15 of the
  /// origin's distance from the centre, across the ray.
  std::optional<double> intersect(const Ray& ray, double height_m = 0.0) const;

  /// Of an eye, with the ellipsoid shrunk by `depth_m` (>= 0: how far terrain may lie below the reference) on both
  /// axes. It hides only what is hidden from every eye within `move_m` (>= 0) of this one, and nothing where one of
  /// them may be inside.
  Horizon horizon(const BodyPosition& eye, double depth_m = 0.0, double move_m = 0.0) const;

  friend constexpr bool operator==(const Ellipsoid&, const Ellipsoid&) = default;

 private:
  double a_;
  double f_;
};

}  // namespace tellurion::geo
