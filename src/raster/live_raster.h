#pragma once

#include <memory>
#include <optional>
#include <string>

#include "raster/raster_file.h"
#include "raster/tile_source.h"

namespace tellurion::raster {

struct LiveOptions {
  RasterOptions raster;  ///< its cacheBytes are shared by the threads that load at the same time
  int tileCells = 0;     ///< 0: the usual for the kind
};

/// Tiles of any raster file that GDAL reads (RasterFile), made when they are asked for: nothing is built, nothing is
/// written. A tile's samples are means over their spacing, on the deepest levels bilinear, so a large file without
/// overviews is slow on coarse levels. Heights' errors are
/// measured against the next level, and on all but the last level before the deepest they are estimates beyond that
/// (liveTile); so a tile of heights costs five times its samples. Fails as RasterFile::open
/// does. Thread-safe: each thread that loads at the same time has the file open once.
io::Result<std::shared_ptr<const TileSource>> liveRaster(const std::string& path, Kind kind, tiling::Scheme scheme,
                                                         const LiveOptions& options = {});

}  // namespace tellurion::raster
