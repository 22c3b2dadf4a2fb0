#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "geo/ellipsoid.h"
#include "scene/camera.h"
#include "scene/oriented_box.h"

namespace tellurion::scene {

/// The four sides of a view's pyramid and the plane through the eye (no far plane: distance is the cut's business). Of
/// a view that is all around it holds everything. Immutable.
class ViewFrustum {
 public:
  static constexpr std::uint8_t kAllPlanes = 0x1F;

  /// margin: how far beyond the sides of the picture it reaches, as a share of half the picture. move_m: of all eyes
  /// that are so near to the view's.
  explicit ViewFrustum(const View& view, double margin = 0.0, double move_m = 0.0);

  /// Conservative: false only when no point of the box falls into the picture.
  bool mayShow(const OrientedBox& box) const { return planesAround(box).has_value(); }
  /// The planes that all of the box lies within, a bit for each; nothing when it lies wholly beyond one. `within`:
  /// those that are known to hold all that the box stands for, and are not tested.
  std::optional<std::uint8_t> planesAround(const OrientedBox& box, std::uint8_t within = 0) const;
  /// Likewise of a sphere.
  bool mayShow(const geo::BodyPosition& centre, double radius_m) const;
  /// How far the box reaches over each of the four sides into the pyramid, in metres; negative: all of it is beyond.
  std::array<double, 4> reachOverSides_m(const OrientedBox& box) const;

 private:
  geo::Vec3 eye_;
  double slack_m_;                   ///< that the planes lie further out
  std::array<geo::Vec3, 5> inward_;  ///< unit normals of planes through the eye
};

/// Of isBeyondHorizon(), once the last corner is known to be hidden.
bool isBeyondHorizonWithItsTop(const OrientedBox& box, const geo::Horizon& horizon);

/// Conservative: true only when every point of the box is hidden. The points hidden behind an ellipsoid are a convex
/// set (its shadow cone, cut off at the horizon's plane), so eight corners decide: first one of the upper, which are
/// the last to be hidden, and of most boxes no other is looked at.
inline bool isBeyondHorizon(const OrientedBox& box, const geo::Horizon& horizon) {
  return horizon.hides(box.corner(OrientedBox::kCorners - 1)) && isBeyondHorizonWithItsTop(box, horizon);
}

/// The largest geo::Horizon::clearance of the box.
double clearanceOfHorizon(const OrientedBox& box, const geo::Horizon& horizon);

}  // namespace tellurion::scene
