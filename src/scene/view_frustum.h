#pragma once

#include <array>

#include "geo/ellipsoid.h"
#include "scene/camera.h"
#include "scene/oriented_box.h"

namespace tellurion::scene {

/// The four sides of a view's pyramid and the plane through the eye (no far plane: distance is the cut's business).
/// Immutable.
class ViewFrustum {
 public:
  explicit ViewFrustum(const View& view);

  /// Conservative: false only when no point of the box falls into the picture.
  bool mayShow(const OrientedBox& box) const;

 private:
  geo::Vec3 eye_;
  std::array<geo::Vec3, 5> inward_;  ///< unit normals of planes through the eye
};

/// Conservative: true only when every point of the box is hidden from the eye by the ellipsoid shrunk by
/// occluderDepth_m. The points hidden behind an ellipsoid are a convex set (its shadow cone, cut off at the horizon's
/// plane), so eight corners decide.
bool isBeyondHorizon(const OrientedBox& box, const geo::BodyPosition& eye, const geo::Ellipsoid& ellipsoid,
                     double occluderDepth_m);

}  // namespace tellurion::scene
