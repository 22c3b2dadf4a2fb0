#pragma once

#include "pyramid/tile_set.h"

namespace tellurion::pyramid {

/// A new folder of quantized-mesh tiles ZOOM/X/Y.terrain, rows counted from the south (TMS), and layer.json, which says
/// which there are.
io::Result<std::unique_ptr<TileSet>> createTerrainFolder(const std::filesystem::path& path, const TileSetFacts& facts);

}  // namespace tellurion::pyramid
