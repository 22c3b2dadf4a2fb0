#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "io/failure.h"
#include "raster/raster.h"

/// The image formats behind codec.h, one file each. Decoders fill `image`, whose size is the only one that they accept.
namespace tellurion::raster {

struct ImageSize {
  int width = 0;
  int height = 0;
  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

io::Result<ImageSize> jpegSize(std::span<const std::byte> bytes);
io::Result<void> decodeJpeg(std::span<const std::byte> bytes, Raster<Rgba8>& image);
io::Result<std::vector<std::byte>> encodeJpeg(const Raster<Rgba8>& image, int quality);

io::Result<ImageSize> pngSize(std::span<const std::byte> bytes);
io::Result<void> decodePng(std::span<const std::byte> bytes, Raster<Rgba8>& image);
io::Result<std::vector<std::byte>> encodePng(const Raster<Rgba8>& image);

io::Result<ImageSize> webpSize(std::span<const std::byte> bytes);
io::Result<void> decodeWebp(std::span<const std::byte> bytes, Raster<Rgba8>& image);
io::Result<std::vector<std::byte>> encodeWebp(const Raster<Rgba8>& image, int quality);

/// The failure of a picture that has another size than it must have.
io::Failure wrongSize(ImageSize found, const Raster<Rgba8>& expected);

}  // namespace tellurion::raster
