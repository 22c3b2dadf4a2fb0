#pragma once

// Inside the room: what the two schemes of six faces (geographic and cube) share. Faces 0 to 3 stand around the
// equator, each a quarter turn of longitude about 90 * root degrees; face 4 is the north cap, face 5 the south cap.

#include <span>

#include "tiling/schemes.h"

namespace tellurion::tiling {

inline constexpr int kFaces = 6;
inline constexpr int kNorthFace = 4;

/// A place on a face: x = 2 u - 1 to the right, y = 2 v - 1 down.
struct FacePoint {
  double x;
  double y;
};
inline FacePoint facePoint(double u, double v) {
  return {2.0 * u - 1.0, 2.0 * v - 1.0};
}

std::span<const RootLinks> faceLinks();

/// What a scheme makes of a polar face, radians.
struct PolarFace {
  double (*colatitude)(const FacePoint& p);           ///< from the face's pole; grows with |x| and with |y|
  double (*longitude)(int root, const FacePoint& p);  ///< monotone along the lines of x and of y
};
geo::GeoRect polarFaceBounds(const PolarFace& face, int root, const Square& q);

/// Of the interval [a, b].
inline double nearestToZero(double a, double b) {
  return a > 0.0 ? a : (b < 0.0 ? b : 0.0);
}
inline double farthestFromZero(double a, double b) {
  return -a > b ? a : b;
}

}  // namespace tellurion::tiling
