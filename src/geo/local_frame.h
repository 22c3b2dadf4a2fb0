#pragma once

#include "geo/ellipsoid.h"

namespace tellurion::geo {

/// An east-north-up frame at a place. At a pole east is the direction that longitude 90 + lon of the given position
/// has there, so a path that ends at the pole along a meridian keeps its axes.
struct LocalFrame {
  BodyPosition origin;
  Vec3 east;  ///< unit vectors in the body frame, right-handed: east x north = up
  Vec3 north;
  Vec3 up;

  Mat3 bodyFromEnu() const { return Mat3(east, north, up); }
};

LocalFrame localFrameAt(const Ellipsoid& ellipsoid, const Geodetic& g);

}  // namespace tellurion::geo
