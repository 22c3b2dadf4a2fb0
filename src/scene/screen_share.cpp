#include "scene/screen_share.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::scene {

double screenShare(const OrientedBox& box, const View& view) {
  constexpr double kNearest_m = 0.1;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const double halfHeight = std::tan(0.5 * view.verticalFov.radians());
  const double halfWidth = halfHeight * view.viewport.width / view.viewport.height;
  geo::Vec2 low(kFar, kFar);
  geo::Vec2 high(-kFar, -kFar);
  for (unsigned i = 0; i < OrientedBox::kCorners; ++i) {
    const geo::Vec3 corner = view.viewFromBody * (box.corner(i) - view.eye);
    if (corner.z > -kNearest_m) return 1.0;
    const geo::Vec2 at = geo::Vec2(corner.x / halfWidth, corner.y / halfHeight) / -corner.z;
    low = geo::Vec2(std::min(low.x, at.x), std::min(low.y, at.y));
    high = geo::Vec2(std::max(high.x, at.x), std::max(high.y, at.y));
  }
  const auto within = [](double from, double to) {
    return std::max(0.0, std::min(to, 1.0) - std::max(from, -1.0)) / 2.0;
  };
  return within(low.x, high.x) * within(low.y, high.y);
}

}  // namespace tellurion::scene
