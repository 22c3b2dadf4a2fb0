#pragma once

#include <optional>

#include "geo/body.h"
#include "io/resources.h"
#include "raster/image_grid.h"
#include "raster/raster.h"

/// Images as servers give them. All functions are thread-safe, and safe on untrusted bytes: they accept only the size
/// that the caller states, allocate no more than a small multiple of it, and answer damage with a failure.
namespace tellurion::raster {

/// JPEG, PNG, WebP, GIF, or TIFF of bytes. Pixels of `transparent` are not covered.
io::Result<Raster<Rgba8>> decodeServiceImage(const io::Resource& resource, int width, int height,
                                             const std::optional<Rgba8>& transparent);

/// Heights in metres as the encoding says. Of a band: PNG, TIFF, or raw numbers row by row (BIL, told from the content
/// type: 16-bit integers or float32, by the number of bytes). Of colours: any lossless picture; `nodata` is then the
/// 24-bit number R * 65536 + G * 256 + B. NODATA besides: NaN, a mask or alpha of 0, what the image itself says, and
/// heights that the body cannot have.
io::Result<Raster<float>> decodeServiceHeights(const io::Resource& resource, int width, int height,
                                               const HeightEncoding& encoding, const geo::Body& body);

}  // namespace tellurion::raster
