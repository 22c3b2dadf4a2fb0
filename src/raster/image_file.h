#pragma once

#include <filesystem>

#include "io/failure.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// Writes a picture, through a temporary file beside it: there is a whole file or none. A picture that is opaque
/// everywhere is written without alpha. A device or a pipe (/dev/null, /dev/stdout) is written to, never replaced.
io::Result<void> writePng(const std::filesystem::path& path, const Raster<Rgba8>& image);

/// Writes a float32 TIFF of one band, NaN its NODATA value, with no georeference; whole or not at all. A device is a
/// failure.
io::Result<void> writeTiffFloat(const std::filesystem::path& path, const Raster<float>& values);

/// Reads a JPEG, PNG or WebP of at most kMaxCodecSide a side. Safe on untrusted files.
io::Result<Raster<Rgba8>> readImageFile(const std::filesystem::path& path);

}  // namespace tellurion::raster
