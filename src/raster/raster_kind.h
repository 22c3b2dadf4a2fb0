#pragma once

#include <string>

#include "io/failure.h"
#include "raster/tile.h"

namespace tellurion::raster {

/// Tells from a raster's own description whether it holds heights or colours. Colours: three bands or more, a palette,
/// a band marked as a colour or as alpha, or bytes without a unit. Any other raster holds heights. Fails as
/// RasterFile::open does on files that GDAL does not read. Thread-safe.
io::Result<Kind> kindOfRaster(const std::string& path);

}  // namespace tellurion::raster
