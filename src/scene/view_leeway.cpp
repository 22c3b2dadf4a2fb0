#include "scene/view_leeway.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::scene {
namespace {

// Measured: docs/selection.md, "Most frames choose nothing".
constexpr double kFrames = 4.0;          ///< that an eye goes on
constexpr double kNearestShare = 0.025;  ///< of the distance to the nearest ground, that it may move
constexpr double kMostTurn = 0.005;

/// How far the picture reaches beyond the sides of the other, which are its own, from one eye: a share of half of them,
/// 0 or less when it does not. What sees all around has no sides.
double reachBeyond(const View& view, const View& other) {
  if (view.isAllAround) return 0.0;
  const Sides sides = view.sides();
  const geo::Mat3 otherFromView = other.viewFromBody * glm::transpose(view.viewFromBody);
  double most = 0.0;
  for (const double right : {sides.left, sides.right}) {
    for (const double up : {sides.bottom, sides.top}) {
      const geo::Vec3 corner = otherFromView * geo::Vec3(right, up, -1.0);
      if (!(corner.z < 0.0)) return std::numeric_limits<double>::infinity();
      const double x = -corner.x / corner.z - sides.middleX();
      const double y = -corner.y / corner.z - sides.middleY();
      most = std::max({most, 2.0 * std::abs(x) / sides.width(), 2.0 * std::abs(y) / sides.height()});
    }
  }
  return most - 1.0;
}

bool areAlike(const View& a, const View& b) {
  return a.sides() == b.sides() && a.viewport.width == b.viewport.width && a.viewport.height == b.viewport.height &&
         a.isAllAround == b.isAllAround && a.agreedPixelAngle == b.agreedPixelAngle;
}

}  // namespace

bool isWithin(const View& view, const View& middle, const Leeway& leeway) {
  if (!areAlike(view, middle) || !(geo::length(view.eye - middle.eye) <= leeway.move_m)) return false;
  return view.viewFromBody == middle.viewFromBody || reachBeyond(view, middle) <= leeway.turn;
}

Leeway leewayFor(const View& before, const View& now, double nearest_m) {
  if (!areAlike(before, now)) return {};
  const double moved_m = geo::length(now.eye - before.eye);
  const bool isTurned = now.viewFromBody != before.viewFromBody;
  const double turned = isTurned ? std::max(reachBeyond(now, before), 0.0) : 0.0;
  const double most_m = kNearestShare * std::max(nearest_m, 0.0);
  // Who leaps, or is too fast for one frame to follow another within it, would only pay for it.
  if (moved_m > most_m || turned > kMostTurn) return {};
  return {.move_m = std::min(kFrames * moved_m, most_m), .turn = std::min(kFrames * turned, kMostTurn)};
}

}  // namespace tellurion::scene
