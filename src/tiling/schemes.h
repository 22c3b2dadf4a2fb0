#pragma once

// Inside the room: what each scheme brings to the one interface. Everything that can be said once for all three (tiles
// at a place, neighbours, wrapping, caps) is said in tiling.cpp and neighbours.cpp over these and the tables of root
// links.

#include <algorithm>
#include <array>
#include <span>

#include "tiling/tiling.h"

namespace tellurion::tiling {

/// What lies across an edge of a root. A place at `along` (u for top and bottom, v for left and right) on the edge lies
/// at `along`, or 1 - `along` when reversed, on the other root's edge; what lies d beyond it lies d inside the other
/// root.
struct RootLink {
  std::uint8_t root;
  Edge edge;
  bool reversed;
};
using RootLinks = std::array<RootLink, 4>;  ///< indexed by Edge

/// Lengths on the unit sphere that a unit step of u or of v covers, anywhere on a root.
struct Scale {
  double smallest;
  double largest;
};

/// A tile's square on its root, exact.
struct Square {
  double u0, v0, u1, v1;
};
inline Square squareOf(const TileId& id) {
  const RootPoint a = rootPointIn(id, 0.0, 0.0);
  const RootPoint b = rootPointIn(id, 1.0, 1.0);
  return {a.u, a.v, b.u, b.v};
}

/// Of the tile that a unit coordinate lies on, of 2^level; 0 for NaN.
inline std::uint32_t tileCoordinate(double unit, int level) {
  const auto tiles = static_cast<double>(std::int64_t{1} << level);
  const double at = unit * tiles;
  return at > 0.0 ? static_cast<std::uint32_t>(std::min(at, tiles - 1.0)) : 0u;
}

/// From radians, wider by a hair against rounding.
geo::GeoRect paddedBounds(double south, double north, double west, double east);

namespace geographic {
geo::Direction direction(const RootPoint& p);
LonLat lonLat(const RootPoint& p);
RootPoint rootPoint(const geo::Direction& d);
geo::GeoRect bounds(const TileId& id);
double area(const TileId& id);
Scale scale();
}  // namespace geographic

namespace cube {
geo::Direction direction(const RootPoint& p);
RootPoint rootPoint(const geo::Direction& d);
geo::GeoRect bounds(const TileId& id);
double area(const TileId& id);
Scale scale();
}  // namespace cube

namespace healpix {
inline constexpr int kRoots = 12;
std::span<const RootLinks> links();
geo::Direction direction(const RootPoint& p);
RootPoint rootPoint(const geo::Direction& d);
geo::GeoRect bounds(const TileId& id);
double area(const TileId& id);
Scale scale();
}  // namespace healpix

}  // namespace tellurion::tiling
