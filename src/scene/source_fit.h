#pragma once

#include <optional>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/tile_source.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// Why a source cannot be a layer of a scene, whose tiling and body these are, of that kind and so many cells a side of
/// a tile; nothing when it can.
std::optional<io::Failure> misfit(const raster::TileSourceInfo& info, const tiling::Tiling& tiling,
                                  const geo::Body& body, raster::Kind kind, int cells);
/// Elevation tiles of so many cells a side can become meshes.
bool isMeshable(int cells);

}  // namespace tellurion::scene
