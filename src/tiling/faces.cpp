#include "tiling/faces.h"

#include <algorithm>
#include <cmath>

namespace tellurion::tiling {

std::span<const RootLinks> faceLinks() {
  static constexpr std::array<RootLinks, kFaces> kLinks{
      {{{{4, Edge::bottom, false}, {1, Edge::left, false}, {5, Edge::top, false}, {3, Edge::right, false}}},
       {{{4, Edge::right, true}, {2, Edge::left, false}, {5, Edge::right, false}, {0, Edge::right, false}}},
       {{{4, Edge::top, true}, {3, Edge::left, false}, {5, Edge::bottom, true}, {1, Edge::right, false}}},
       {{{4, Edge::left, false}, {0, Edge::left, false}, {5, Edge::left, true}, {2, Edge::right, false}}},
       {{{2, Edge::top, true}, {1, Edge::top, true}, {0, Edge::top, false}, {3, Edge::top, false}}},
       {{{0, Edge::bottom, false}, {1, Edge::bottom, false}, {2, Edge::bottom, true}, {3, Edge::bottom, true}}}}};
  return kLinks;
}

geo::GeoRect polarFaceBounds(const PolarFace& face, int root, const Square& q) {
  const FacePoint a = facePoint(q.u0, q.v0);
  const FacePoint b = facePoint(q.u1, q.v1);
  const double most = geo::kPi / 2.0 - face.colatitude({nearestToZero(a.x, b.x), nearestToZero(a.y, b.y)});
  const double least = geo::kPi / 2.0 - face.colatitude({farthestFromZero(a.x, b.x), farthestFromZero(a.y, b.y)});
  const double south = root == kNorthFace ? least : -most;
  const double north = root == kNorthFace ? most : -least;
  const bool poleInside = a.x < 0.0 && b.x > 0.0 && a.y < 0.0 && b.y > 0.0;
  if (poleInside) {
    geo::GeoRect r = paddedBounds(south, north, 0.0, 0.0);
    r.west = geo::Angle::radians(-geo::kPi);
    r.width = geo::Angle::radians(2.0 * geo::kPi);
    return r;
  }
  // The longitudes of the corners, from that of the middle. A corner at the pole has none.
  const double centre = face.longitude(root, {0.5 * (a.x + b.x), 0.5 * (a.y + b.y)});
  double west = centre;
  double east = centre;
  for (const FacePoint& corner : {a, {b.x, a.y}, b, {a.x, b.y}}) {
    if (corner.x == 0.0 && corner.y == 0.0) continue;
    const double offset = std::remainder(face.longitude(root, corner) - centre, 2.0 * geo::kPi);
    west = std::min(west, centre + offset);
    east = std::max(east, centre + offset);
  }
  return paddedBounds(south, north, west, east);
}

}  // namespace tellurion::tiling
