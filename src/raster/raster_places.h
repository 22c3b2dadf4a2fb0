#pragma once

#include "raster/placement.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// The most that a sample of a tile is read beside its place: less than that is lost anyhow, for weights between pixels
/// are whole 256ths.
inline constexpr double kRasterPlaceError_pixels = 1.0 / 256.0;

/// Where the samples of an imagery tile lie in a raster, gutter included, row by row, with the sides of squares of
/// angular side `side` (0: points, no sides); not finite at a corner of the gutter that no single place owns. Exact in
/// the gutter and on a lattice, elsewhere within kRasterPlaceError_pixels.
PixelPlaces tilePixels(const Placement& placement, const tiling::Tiling& tiling, const tiling::TileId& id, int cells,
                       geo::Angle side);

}  // namespace tellurion::raster
