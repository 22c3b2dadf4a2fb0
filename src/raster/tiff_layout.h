#pragma once

#include <cstddef>
#include <span>

#include "io/failure.h"
#include "raster/image_formats.h"

namespace tellurion::raster {

/// The size of the first picture of a TIFF or BigTIFF, of either byte order, all of whose directories, strips and tiles
/// lie within the bytes. Fails otherwise. Safe on untrusted bytes; no pixel is looked at.
io::Result<ImageSize> sizeOfWholeTiff(std::span<const std::byte> bytes);

}  // namespace tellurion::raster
