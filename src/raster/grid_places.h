#pragma once

#include <vector>

#include "raster/grid_geometry.h"
#include "raster/tile.h"

namespace tellurion::raster {

inline constexpr double kPlaceError_pixels = 0.02;

/// Where the samples of a tile lie in the plane of a grid, gutter included, row by row; not finite at a corner of the
/// gutter that no single place owns.
///
/// Elevation: each exactly, so that neighbours have the same bits. Imagery: exactly on a lattice and in the gutter;
/// between, quadratic where that is off by less than kPlaceError_pixels of the finest pixels that the tile reads.
PlanePlaces tilePlaces(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                       int cells);

/// The images that a tile is made of where all exist, from a lattice of places: a few more, and seldom one too few. The
/// number is bounded.
std::vector<GridImageId> imagesFor(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id,
                                   Kind kind, int cells);

}  // namespace tellurion::raster
