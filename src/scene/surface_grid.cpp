#include <cmath>

#include "scene/surface_grid.h"

namespace tellurion::scene {
namespace {

/// The place of a sample of the tile or its gutter; nothing where no root owns it.
std::optional<tiling::RootPoint> placeOf(const tiling::Tiling& tiling, const tiling::TileId& id, int cells, int col,
                                         int row) {
  const tiling::RootPoint p =
      tiling::rootPointIn(id, static_cast<double>(col) / cells, static_cast<double>(row) / cells);
  const bool inside = p.u >= 0.0 && p.u <= 1.0 && p.v >= 0.0 && p.v <= 1.0;
  return inside ? std::optional(p) : tiling.wrapped(p);
}

}  // namespace

SurfaceGrid surfaceGrid(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                        const GroundSamples& heights) {
  SurfaceGrid grid{.id = id, .cells = heights.width - 3};
  grid.up.resize(heights.samples.size());
  grid.positions.resize(heights.samples.size());
  grid.heights_m = heights.samples;
  for (int row = -1; row <= grid.cells + 1; ++row) {
    for (int col = -1; col <= grid.cells + 1; ++col) {
      const bool outerCol = col < 0 || col > grid.cells;
      const bool outerRow = row < 0 || row > grid.cells;
      if (outerCol && outerRow) continue;
      const auto place = placeOf(tiling, id, grid.cells, col, row);
      if (!place) continue;
      const std::size_t i = grid.index(col, row);
      grid.up[i] = tiling.direction(*place);
      grid.positions[i] = ellipsoid.bodyFromDirection(grid.up[i], static_cast<double>(heights.samples[i]));
    }
  }
  return grid;
}

double cellSide_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid) {
  return tiling.metrics(grid.id.level).largestEdge.radians() * ellipsoid.semiMajorAxis_m() / grid.cells;
}

}  // namespace tellurion::scene
