#pragma once

#include <filesystem>
#include <stop_token>
#include <string>

#include "raster/tile_source.h"
#include "scene/globe.h"

namespace tellurion::scene {

/// The share with which a BuildSink is told a warning about a raster ("PATH: sentence") instead of progress.
inline constexpr double kWarningShare = -1.0;

/// Opens the sources of all layers of a scene. Rasters are built into tile databases in the cache folder first, unless
/// one that was built from the same files (path, size, time of change; side files too) for the same tiling and body, by
/// the same version of the builder, is there and opens. While another program builds the same one, this one waits. A
/// raster whose spatial reference names another body than the scene's is a failure. A stop asked for while rasters are
/// built, or waited for, gives Failure::Code::cancelled that names the raster; the next call goes on where it was.
///
/// Rasters that are live, and catalogues, are opened as they are. Services are left to be opened (LayerSource::opening)
/// with `resources`, which where there are none are made for all of them as `online` says (withCacheFile). imageBytes:
/// for decoded images of all services.
io::Result<GlobeLayers> openLayers(const Scene& scene, const BuildSink& progress, const std::stop_token& stop = {},
                                   const io::ResourceOptions& online = {},
                                   std::uint64_t imageBytes = std::uint64_t{128} << 20,
                                   std::shared_ptr<io::Resources> resources = nullptr);

/// Where it names no cache file, and has bytes for one: online.db in the cache folder, which is made.
io::ResourceOptions withCacheFile(io::ResourceOptions options);

/// Whether a source is a tile database, finished or not: by its name, else by its first bytes.
bool isTileDatabase(const std::string& path);

/// $XDG_CACHE_HOME/tellurion, else ~/.cache/tellurion, else a folder of that name in the temporary folder.
std::filesystem::path cacheFolder();

}  // namespace tellurion::scene
