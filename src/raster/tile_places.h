#pragma once

#include <optional>
#include <vector>

#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// Where sample (column, row) of a tile lies, gutter included (raster/tile.h). Nothing at a corner of the gutter that
/// no single place owns.
std::optional<geo::Direction> placeOf(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                                      int column, int row);

/// The places of those samples of a tile that are not known yet, row by row.
struct OpenPlaces {
  std::vector<std::size_t> indices;  ///< into the tile's samples
  std::vector<geo::Direction> places;
};
OpenPlaces openPlaces(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                      const std::vector<bool>& known);

/// Their indices alone.
std::vector<std::size_t> openSamples(const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells,
                                     const std::vector<bool>& known);

/// Samples a side, gutter included.
int sideOf(Kind kind, int cells);

}  // namespace tellurion::raster
