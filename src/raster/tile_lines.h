#pragma once

#include <span>
#include <vector>

#include "raster/placement.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

/// Tiles of meridians and parallels over rasters of longitudes and latitudes: their samples' pixels without a sine,
/// and, but for the caps, a function of the column and a function of the row.
namespace tellurion::raster {

/// Whether the functions below apply. It is a matter of the tiling and the raster, not of a tile: who samples one tile
/// of them this way samples all so, and a place that several tiles share has one pixel, to the last bit.
bool isOfLonLat(const Placement& placement, const tiling::Tiling& tiling);

/// Of these, tiles whose columns run along meridians and rows along parallels: all but those of the caps.
bool isOfLines(const tiling::TileId& id);

/// Where the columns and the rows of a tile's samples lie, in pixels, gutter included.
struct PixelLines {
  std::vector<double> col;  ///< of each column
  std::vector<double> row;  ///< of each row; NaN of a row that is no line (a gutter across the border of a cap)
};
/// Only where isOfLines().
PixelLines pixelLines(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                      int cells);

/// The same of any samples, one by one; not finite at corners of the gutter that no single place owns.
void pixelsOfSamples(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                     int cells, std::span<const std::size_t> indices, PixelPlaces& out);

}  // namespace tellurion::raster
