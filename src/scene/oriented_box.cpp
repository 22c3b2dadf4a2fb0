#include "scene/oriented_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::scene {

double OrientedBox::distance_m(const geo::BodyPosition& p) const {
  const geo::Vec3 d = p - centre;
  double squared = 0.0;
  for (const geo::Vec3& axis : halfAxes) {
    // Times the axis's length, which spares its root.
    const double half = geo::dot(axis, axis);
    const double outside = std::abs(geo::dot(d, axis)) - half;
    if (outside > 0.0) squared += outside * outside / half;
  }
  return std::sqrt(squared);
}

bool OrientedBox::contains(const geo::BodyPosition& p, double slack_m) const {
  return distance_m(p) <= slack_m;
}

OrientedBox boxAround(std::span<const geo::BodyPosition> points, const geo::Vec3& axisU, const geo::Vec3& up,
                      double margin_m) {
  const geo::Vec3 u = geo::normalize(axisU);
  const geo::Vec3 v = geo::normalize(geo::cross(up, u));
  const std::array<geo::Vec3, 3> axes{u, v, geo::cross(u, v)};
  const geo::BodyPosition reference = points.front();
  OrientedBox box{.centre = reference};
  for (std::size_t i = 0; i < 3; ++i) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const geo::BodyPosition& p : points) {
      const double along = geo::dot(p - reference, axes[i]);
      low = std::min(low, along);
      high = std::max(high, along);
    }
    box.centre.m += axes[i] * ((low + high) / 2.0);
    box.halfAxes[i] = axes[i] * std::max((high - low) / 2.0 + margin_m, 1e-6);
  }
  return box;
}

OrientedBox grown(OrientedBox box, double by_m) {
  for (geo::Vec3& axis : box.halfAxes)
    axis *= 1.0 + by_m / geo::length(axis);
  return box;
}

}  // namespace tellurion::scene
