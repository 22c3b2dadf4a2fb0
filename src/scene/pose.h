#pragma once

#include <optional>

#include "scene/picking.h"

namespace tellurion::scene {

/// A view told relative to the ground under it, without the longitude and heading that a pole takes away: what
/// navigation computes with. `up` is the ellipsoid's normal at the eye, `forward` the level unit vector (body frame,
/// perpendicular to up) that the heading points to.
struct Pose {
  geo::Direction up;
  double height_m = 0.0;  ///< above the ellipsoid
  geo::Vec3 forward{0.0, 1.0, 0.0};
  geo::Angle pitch;
  geo::Angle roll;

  geo::Vec3 right() const { return geo::cross(forward, up.n); }
};

Pose poseOf(const View& view, const geo::Ellipsoid& ellipsoid);

/// Field of view and viewport are those of `like`.
View viewOf(const Pose& pose, const geo::Ellipsoid& ellipsoid, const View& like);

/// Clockwise from north, (-180, 180] degrees. At a pole north is the meridian of longitude 180 (north pole) or 0 (south
/// pole).
geo::Angle headingOf(const Pose& pose);

/// The same pose with its heading turned clockwise about its up.
Pose turnedBy(const Pose& pose, geo::Angle clockwise);

/// The pose taken along the great circle to another place. It keeps its heading; near the poles, and where that would
/// turn the eye by more than a right angle against the ground, it keeps its direction relative to the way instead, with
/// a smooth change between the two.
Pose carriedTo(const Pose& pose, const geo::Direction& up, double height_m);

/// The pose with heading and pitch such that the unit vector `target_body` falls on the unit vector `seen_view` (view
/// axes). Of two ways the one whose pitch is nearer. Nothing when no pitch within +-90 degrees does it.
std::optional<Pose> facing(const Pose& pose, const geo::Vec3& target_body, const geo::Vec3& seen_view);

}  // namespace tellurion::scene
