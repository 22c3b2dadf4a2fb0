#pragma once

#include <string>

#include "io/failure.h"

namespace tellurion::raster {

/// Whether a file is a GDAL virtual raster (VRT), by its first bytes.
bool isVirtualRaster(const std::string& path);

/// Fails unless the file is a plain mosaic: bands that are made of windows of raster files of the local file system, at
/// most scaled, each of which is there. They lie in its folder or below (names count as they are written: links are the
/// user's own), or anywhere where `sourcesAnywhere` says that the user named it (RasterOptions). What computes, warps, asks a server or a database, reads raw bytes,
/// has options for drivers or names what may name more (virtual rasters, labels) is refused, since a document that
/// comes from somewhere could reach anything with it.
io::Result<void> checkVirtualRaster(const std::string& path, bool sourcesAnywhere);

}  // namespace tellurion::raster
