#pragma once

#include <cstdint>

#include "raster/lon_lat_grid.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// How much of a picture counts, place by place: 0 nothing, 1 all; bilinear between the nodes, in steps of 1/255.
/// Immutable once made.
struct WeightMap {
  LonLatGrid grid;
  Raster<std::uint8_t> weights;

  double at(const geo::Direction& place) const;
};

/// The most nodes a side that a map is made of: 64 MiB at most.
inline constexpr int kMostMapNodes = 8192;

/// The distance in metres of each node that is marked to the nearest that is not, `most` at most; 0 where it is not
/// marked. On the plane that the row's own parallel unrolls to, so true to some percent within a few degrees.
/// borderCounts: beyond the rectangle nothing is marked (where it neither goes around nor ends at a pole); else the
/// border is nobody's.
Raster<float> distancesToUnmarked(const LonLatGrid& grid, const Raster<std::uint8_t>& marked, const geo::Body& body,
                                  double most_m, bool borderCounts);

/// 0 at 0, 1 at `width_m` and beyond, with no kink at either; a step where width_m is 0.
double rampOf(double distance_m, double width_m);

}  // namespace tellurion::raster
