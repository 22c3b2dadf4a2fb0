#pragma once

// Inside the room: HEALPix's plane, with what single places and batches of them go through.
//
// HEALPix (Gorski and others, 2005) in its own plane: `ring` counts from 0 at the north pole to 4 at the south pole
// (HEALPix's ring index divided by the number of pixels a side), `octants` is the longitude in units of 45 degrees. A
// root's square lies in it as a diamond: ring = ringOf(north corner) + u + v, octants = (middle) + (u - v), the last
// shrunk to a point towards a pole.

#include <algorithm>
#include <cmath>
#include <limits>

#include "tiling/octants.h"
#include "tiling/schemes.h"

namespace tellurion::tiling::healpix {

inline constexpr double kBorder = 2e-15;  ///< in u and v: nearer to a root's border than this is on it

inline double northCornerRing(int root) {
  return static_cast<double>(root >> 2);
}
inline double middleOctants(int root) {
  return 2.0 * (root & 3) + static_cast<double>((root & 4) == 0);
}

struct PlanePoint {
  double ring;
  double octants;  // not yet within one turn
};

// Here and below, what cannot be foreseen of a place is a number, 0 or 1, and not a branch.
inline PlanePoint planeFromRoot(const RootPoint& p) {
  const double ring = northCornerRing(p.root) + (p.u + p.v);
  const double width = std::min(std::min(ring, 4.0 - ring), 1.0);  // of a root, shrunk towards a pole
  const double offset =
      std::max(-1.0, std::min(1.0, (p.u - p.v) / std::max(std::numeric_limits<double>::min(), width)));
  return {ring, middleOctants(p.root) + offset};
}

// [-1, 9] to [0, 8), exact.
inline double withinTurn(double octants) {
  return octants + 8.0 * oneIfLess(octants, 0.0) - 8.0 * (1.0 - oneIfLess(octants, 8.0));
}

struct Height {
  double sin;
  double cos;
};

// Of the latitude on a ring.
inline Height heightOf(double ring) {
  const double fromPole = std::min(ring, 4.0 - ring);
  const auto cap = static_cast<double>(fromPole < 1.0);
  const double side = 2.0 * oneIfLess(ring, 2.0) - 1.0;
  const double t = fromPole * fromPole / 3.0;  // 1 - |sin lat| in a cap
  const double s = (2.0 - ring) * (2.0 / 3.0);
  const double cos2 = cap * (t * (2.0 - t)) + (1.0 - cap) * ((1.0 - s) * (1.0 + s));
  return {cap * (side * (1.0 - t)) + (1.0 - cap) * s, std::sqrt(cos2)};
}

/// direction(), to be put into loops.
inline geo::Direction directionInline(const RootPoint& p) {
  const PlanePoint plane = planeFromRoot(p);
  const Height lat = heightOf(plane.ring);
  const geo::SinCos lon = sinCosFewOctants(withinTurn(plane.octants));
  return {geo::Vec3(lat.cos * lon.cos + 0.0, lat.cos * lon.sin + 0.0, lat.sin + 0.0)};
}

/// Where a direction lies, before it is known on which root.
struct PlaceOnPlane {
  double turn;      ///< longitude in octants, [0, 8]; NaN where the direction has one
  double fromPole;  ///< in rings, of the nearer pole, where that is below 1: in a cap
  double z;
};

inline PlaceOnPlane placeOnPlane(const geo::Direction& d) {
  const double octants = octantsOf(d.n.y, d.n.x);
  return {.turn = octants + 8.0 * oneIfLess(octants, 0.0),
          .fromPole = std::sqrt(3.0 * (d.n.x * d.n.x + d.n.y * d.n.y) / (1.0 + std::fabs(d.n.z))),
          .z = d.n.z};
}
inline double beltRing(const PlaceOnPlane& place) {
  return std::min(3.0, std::max(1.0, 2.0 - 1.5 * place.z));
}

/// The root point of a place inside a root, and whether it is inside: where not, it is on a border, which may be on
/// several roots, or NaN, and the root point is none.
struct InsideRoot {
  double u;
  double v;
  double root;
  double fromBorder;  ///< in u and v; not above kBorder: on a border
  bool isInside() const { return fromBorder > kBorder; }
  RootPoint point() const { return {static_cast<int>(root), u, v}; }
};

// Towards 0, for |x| < 2^31.
inline double wholePart(double x) {
  return static_cast<int>(x);
}

inline InsideRoot rootPointInside(const PlaceOnPlane& place) {
  const double cap = oneIfLess(place.fromPole, 1.0);
  const double south = oneIfLess(place.z, 0.0);
  // Numbers that any integer can hold, for NaN too.
  const double turn = std::max(0.0, std::min(8.0, place.turn));

  const double quarter = wholePart(turn * 0.5);
  const double across = turn - 2.0 * quarter - 1.0;
  const double right = place.fromPole * (1.0 + across) / 2.0;
  const double left = place.fromPole * (1.0 - across) / 2.0;
  const double capU = (1.0 - south) * right + south * (1.0 - left);
  const double capV = (1.0 - south) * left + south * (1.0 - right);

  // The plane between the caps is cut by two families of parallel lines: a diamond is a column i of one, j of the
  // other.
  const double ring = beltRing(place);
  const double a = (ring + turn - 1.0) / 2.0;  // 0 to 5
  const double b = (ring - turn + 1.0) / 2.0;  // -3 to 2
  const double i = wholePart(a);
  const double j = wholePart(b) - oneIfLess(b, 0.0);
  const double row = i + j;
  const double column = i - oneIfLess(1.0, row);

  const double u = cap * capU + (1.0 - cap) * (a - i);
  const double v = cap * capV + (1.0 - cap) * (b - j);
  const double root = cap * (quarter + 8.0 * south) + (1.0 - cap) * (4.0 * row + column - 4.0 * oneIfLess(3.0, column));
  // In a cap |across| is 1 on the meridians between its roots; where both are 0, and in NaN, nothing is inside.
  const double fromMiddle = std::max(std::fabs(u - 0.5), std::fabs(v - 0.5));
  const double fromBorder = std::min(0.5 - fromMiddle, 1.0 - cap * std::fabs(across));
  const double notANumber = 0.0 * (place.turn + place.fromPole);  // or 0
  const double isRoot = oneIfLess(-1.0, root) * oneIfLess(root, kRoots);
  return {u, v, root, fromBorder * isRoot + notANumber};
}

/// The same for places on borders, where the lowest root counts. {0, NaN, NaN} for NaN.
RootPoint rootPointOnBorder(const PlaceOnPlane& place);

}  // namespace tellurion::tiling::healpix
