#pragma once

#include <cstddef>
#include <vector>

#include "geo/ellipsoid.h"
#include "pyramid/map_tiles.h"

namespace tellurion::pyramid {

/// Cells a side of a terrain tile: 65 x 65 vertices.
inline constexpr int kTerrainCells = 64;

/// The vertices of a geodetic tile, rows from the north: as near to equal steps as the format's 15 bits a side allow,
/// and just where it decodes them to. On an edge they are those of the neighbour to the last bit.
PlaceGrid terrainPlaces(const MapTile& tile);

/// Metres between two heights of all tiles of a zoom: a power of two, as small as the 15 bits of a tile of heights
/// between `lowest_m` <= 0 and `highest_m` >= 0 allow, and no less than 1/128.
double terrainStep_m(double lowest_m, double highest_m);

/// A tile of quantized-mesh 1.0, without extensions, for `heights` at terrainPlaces(); NODATA becomes height 0. Decoded
/// heights are the multiples of `step_m` next to them, whatever the tile, so that tiles of a zoom meet without a crack.
/// The header's lowest height is the tile's, the highest is that plus 32767 steps: what exactness takes.
std::vector<std::byte> encodeQuantizedMesh(const raster::Raster<float>& heights, const MapTile& tile,
                                           const geo::Ellipsoid& ellipsoid, double step_m);

}  // namespace tellurion::pyramid
