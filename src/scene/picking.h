#pragma once

#include <functional>
#include <optional>

#include "geo/ellipsoid.h"
#include "scene/camera.h"

namespace tellurion::scene {

/// A place on the picture in pixels, continuous: (0, 0) is the top-left corner of the top-left pixel, whose centre is
/// (0.5, 0.5); x to the right, y down.
struct PixelPosition {
  double x = 0.0;
  double y = 0.0;
};

PixelPosition centreOf(const Viewport& viewport);

/// The ground as navigation sees it: a reference ellipsoid and the height of what lies on it.
struct Ground {
  geo::Ellipsoid ellipsoid;
  /// Metres above the ellipsoid; nothing where none is known (yet). Called from the caller's thread only.
  std::function<std::optional<double>(const geo::Direction&)> height_m;

  double heightOrZero_m(const geo::Direction& d) const { return height_m ? height_m(d).value_or(0.0) : 0.0; }
};

/// Metres above the ground under it, along the ellipsoid's normal.
double heightAboveGround_m(const geo::BodyPosition& p, const Ground& ground);

/// The direction from the eye, in view axes (x right, y up, z backwards), of unit length, through a place on the
/// picture's plane; places outside the picture are fine.
geo::Vec3 viewDirectionThrough(const View& view, PixelPosition pixel);

/// The half-line from the eye through a place on the picture, body frame; direction of unit length, so distances are
/// metres.
geo::Ray rayThrough(const View& view, PixelPosition pixel);

/// Where a point falls on the picture, or beside it; nothing when it is not in front of the eye. The error is that of
/// the subtraction of two positions: about 1e-9 m seen from the eye.
std::optional<PixelPosition> pixelOf(const View& view, const geo::BodyPosition& point);

/// The first point of the ground that the ray meets, found by marching with steps in proportion to the height above the
/// ground and then halving; exact to a nanometre on the ground function where the ground's slope stays under 60 degrees
/// (a spike thinner than half a pixel may be missed). Where the ground lies under the ellipsoid at the rim of the body
/// and is missed, the ellipsoid counts; nothing in the sky. Terrain higher than a hundredth of the body's radius is not
/// seen. A ray that starts under the ground meets it at once.
std::optional<geo::BodyPosition> groundAlong(const geo::Ray& ray, const Ground& ground, double pixelAngle);

/// The point of the ground under a place on the picture; nothing in the sky.
std::optional<geo::BodyPosition> pointUnder(const View& view, PixelPosition pixel, const Ground& ground);

}  // namespace tellurion::scene
