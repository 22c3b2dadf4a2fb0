#pragma once

#include <cstdint>
#include <span>

#include "geo/geodetic.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// What points are found by, whatever the tiling that is built.
inline const tiling::Tiling kPointIndex(tiling::Scheme::cube);

/// A point with a height, in 16 bytes: its cell of the cube tiling's deepest level, and where in it (0.3 micrometres on
/// Earth).
struct PackedPoint {
  std::uint64_t cell = 0;  ///< in an order in which what lies below a tile is one run (healpixNested)
  std::uint16_t u = 0;     ///< 65536ths of the cell
  std::uint16_t v = 0;
  float height_m = 0.0F;
};
PackedPoint packedPoint(const geo::Direction& place, float height_m);
geo::Direction placeOf(const PackedPoint& point);

/// At the mean of their places and heights, of points of one root; one at least.
PackedPoint meanPoint(std::span<const PackedPoint> points);

/// The cell of a level that a point lies in, as a number in the points' order.
std::uint64_t cellOf(const PackedPoint& point, int level);

}  // namespace tellurion::raster
