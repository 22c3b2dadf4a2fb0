#pragma once

#include "io/resources.h"
#include "raster/tile.h"

namespace tellurion::raster {

/// What an image of a service must be.
struct ExpectedImage {
  Kind kind = Kind::imagery;
  int width = 256;
  int height = 256;
  int rawSampleBytes = 0;  ///< of raw heights (BIL): bytes of a sample; 0: a picture
  bool ready = false;      ///< a ready-made tile, where an empty answer means that there is none; not drawn on demand
};

/// For io::ResourceRequest::check. True: a picture (PNG, JPEG, WebP, TIFF, GIF) or raw heights of the right size that
/// do not end early, as far as headers and trailers tell; false: the server says that there is nothing at this place. A
/// failure quotes what the server says instead. Quick, pure, safe on untrusted bytes.
io::Result<bool> checkImage(const io::Resource& resource, const ExpectedImage& expected);

}  // namespace tellurion::raster
