#pragma once

#include <string>

#include "io/failure.h"

namespace tellurion::raster {

/// Whether a file is a GDAL virtual raster (VRT), by its first bytes.
bool isVirtualRaster(const std::string& path);

/// Fails unless the file is a plain mosaic: bands that are made of windows of raster files in its own folder or below,
/// at most scaled, each of which is there. What computes, warps, asks a server, reads raw bytes, has options for
/// drivers or names other virtual rasters is refused, since a document that comes from somewhere could reach anything
/// with it. Names count as they are written: links are the user's own.
io::Result<void> checkVirtualRaster(const std::string& path);

}  // namespace tellurion::raster
