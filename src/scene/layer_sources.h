#pragma once

#include <filesystem>
#include <string>

#include "raster/tile_source.h"
#include "scene/globe.h"

namespace tellurion::scene {

/// Opens the sources of all layers of a scene. Rasters are built into tile databases in the cache folder first, unless
/// one that was built from the same file (path, size, time of change) for the same tiling and body is there.
io::Result<GlobeLayers> openLayers(const Scene& scene, const BuildSink& progress);

/// Whether a source is a tile database, by its name.
bool isTileDatabase(const std::string& path);

/// $XDG_CACHE_HOME/tellurion, else ~/.cache/tellurion, else a folder of that name in the temporary folder.
std::filesystem::path cacheFolder();

}  // namespace tellurion::scene
