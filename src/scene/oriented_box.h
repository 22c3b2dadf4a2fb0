#pragma once

#include <array>
#include <span>

#include "geo/geodetic.h"

namespace tellurion::scene {

/// A box in any orientation: centre +- half axes, which are orthogonal to each other. Body frame, metres.
struct OrientedBox {
  geo::BodyPosition centre;
  std::array<geo::Vec3, 3> halfAxes{};

  static constexpr unsigned kCorners = 8;
  geo::BodyPosition corner(unsigned i) const {
    const auto side = [i](unsigned bit) { return (i & bit) != 0 ? 1.0 : -1.0; };
    return centre + (halfAxes[0] * side(1) + halfAxes[1] * side(2) + halfAxes[2] * side(4));
  }
  /// From a point to the nearest point of the box; 0 inside.
  double distance_m(const geo::BodyPosition& p) const;
  bool contains(const geo::BodyPosition& p, double slack_m = 0.0) const;
};

/// The box around points with two of its axes turned to `axisU` (kept) and `up` (made orthogonal to it), grown by
/// margin_m on all sides. Points must not be empty; the axes must not be parallel.
OrientedBox boxAround(std::span<const geo::BodyPosition> points, const geo::Vec3& axisU, const geo::Vec3& up,
                      double margin_m);

/// With its faces moved outwards.
OrientedBox grown(OrientedBox box, double by_m);

}  // namespace tellurion::scene
