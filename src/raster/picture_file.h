#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "io/failure.h"
#include "raster/image_formats.h"

/// What a picture's file tells of itself without its pixels being decoded. Quick, pure, safe on untrusted bytes.
namespace tellurion::raster {

enum class PictureFormat : std::uint8_t { jpeg, png, webp, gif, tiff };

/// By its first bytes; nothing: none of these.
std::optional<PictureFormat> pictureFormatOf(std::span<const std::byte> bytes);

/// The size of a picture that came whole, as far as the format tells: JPEG and GIF by their end marks, WebP by its
/// stated length, PNG by the checksum of each of its chunks, TIFF by the places of its directories and strips or tiles.
/// Up to 1024 bytes may follow. Fails where it is cut short or damaged, or is no picture.
io::Result<ImageSize> sizeOfWholePicture(std::span<const std::byte> bytes);

}  // namespace tellurion::raster
