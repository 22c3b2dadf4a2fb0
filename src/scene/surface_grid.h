#pragma once

#include <vector>

#include "geo/ellipsoid.h"
#include "raster/raster.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// The heights of a tile as its mesh needs them: (cells + 3)^2 with a gutter as in raster::ElevationTile, metres, all
/// finite; the samples on the tile's edges must be those that the tiles next to it have there. cells is a power of
/// two, 4..128.
using GroundSamples = raster::Raster<float>;

/// Where the samples of a tile lie in space, gutter included (its four corners are not filled in).
struct SurfaceGrid {
  tiling::TileId id;
  int cells = 0;
  std::vector<geo::Direction> up;            ///< (cells + 3)^2, row-major
  std::vector<geo::BodyPosition> positions;  ///< likewise, in full precision
  std::vector<float> heights_m;              ///< likewise, above the ellipsoid

  /// Sample (col, row) from -1 to cells + 1.
  std::size_t index(int col, int row) const {
    return static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(cells + 3) + static_cast<std::size_t>(col + 1);
  }
};
SurfaceGrid surfaceGrid(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                        const GroundSamples& heights);

/// The longest side of a cell of its samples, metres.
double cellSide_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid);

}  // namespace tellurion::scene
