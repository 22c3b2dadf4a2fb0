#pragma once

#include <cstdint>
#include <memory>

#include "raster/raster.h"
#include "scene/frame.h"

namespace tellurion::scene {

/// A texture with all its mip levels from its finest: sRGB and coverage, not premultiplied. Compressed: an eighth of
/// the bytes where it is covered all over, a quarter else.
std::shared_ptr<const TextureImage> textureFrom(raster::Raster<raster::Rgba8> finest, bool compress = false);

/// Of its pixels, with all mip levels: what a copy on the GPU takes.
std::uint64_t pixelBytes(const TextureImage& image);

/// Of all pixels together: the middle of the smallest mip level.
raster::Rgba8 meanOf(const TextureImage& image);

}  // namespace tellurion::scene
