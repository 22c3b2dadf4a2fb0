#pragma once

#include <vector>

#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// A sample of an elevation tile without its gutter: column and row from 0 to cells.
struct SampleView {
  tiling::TileId tile;
  int column = 0;
  int row = 0;

  friend bool operator==(const SampleView&, const SampleView&) = default;
};

/// The sample `depth` steps in from an edge, `along` it with u or v.
SampleView viewFromEdge(const tiling::TileId& tile, tiling::Edge edge, int along, int depth, int cells);

/// The same place, `depth` steps beyond an edge of a tile, seen from the tile across.
SampleView viewAcross(const tiling::Tiling& tiling, const tiling::TileId& tile, tiling::Edge edge, int along, int depth,
                      int cells);

/// All tiles of the level that hold the sample's place: one inside, two on an edge, three or four at a corner.
std::vector<SampleView> viewsOf(const tiling::Tiling& tiling, const SampleView& sample, int cells);

}  // namespace tellurion::pyramid
