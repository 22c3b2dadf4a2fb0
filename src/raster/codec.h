#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "io/failure.h"
#include "raster/raster.h"

/// Tile payloads. All functions are thread-safe. The decoders are safe on untrusted bytes (tests/fuzz/codec_fuzz.cpp):
/// they accept only the size that the caller states, allocate no more than a small multiple of it, and answer damage
/// with a failure.
///
/// An elevation payload, byte by byte:
///   0      1: multiples of a step; 2: float32
///   1..8   only for 1: the step in metres, float64, little-endian, in (0, 1e9]
///   then   one zstd frame of 4 * width * height bytes: a 32-bit code a sample, row by row, stored as four planes (all
///   lowest
///          bytes, then all second ones, ...)
/// Codes for 1: 0 is NODATA, else 1 + zigzag(value - guess) with value = round(height / step), |value| <= 2^28,
/// zigzag(d) = 0, 1, 2, 3, ... for d = 0, -1, 1, -2, ... The guess is left + above - aboveLeft; in the first row left,
/// in the first column above, at the first sample 0. A NODATA sample stands in those sums as its own guess, clamped to
/// +-2^28. Codes for 2: zigzag(o - o of the sample before, 0 at first) modulo 2^32; o is the float's bits, all inverted
/// when the sign bit is set, else with the sign bit set.
namespace tellurion::raster {

/// The largest side that any codec here takes.
inline constexpr int kMaxCodecSide = 16384;

/// Heights, compressed without loss. step_m in (0, 1e9]: heights are integer multiples of it (others are rounded to the
/// nearest one) and |height / step_m| <= 2^28, else the encoder falls back to step_m = 0. step_m = 0: float32 bit for
/// bit, but every NaN becomes kNoData.
std::vector<std::byte> encodeElevation(const Raster<float>& heights, double step_m);
io::Result<Raster<float>> decodeElevation(std::span<const std::byte> bytes, int width, int height);

enum class ImageFormat : std::uint8_t { jpeg, png, webp };
std::string_view nameOf(ImageFormat format);

/// quality 1..100; PNG is without loss and ignores it, WebP is without loss at 100 (the colour under coverage 0 is free
/// to change). JPEG drops coverage. An empty raster or one beyond kMaxCodecSide is invalidArgument.
io::Result<std::vector<std::byte>> encodeImage(const Raster<Rgba8>& image, ImageFormat format, int quality);

/// The format is told from the bytes. 16-bit PNGs come out in 8 bits, grey as colour; CMYK JPEGs and animations are
/// unsupported; a picture that ends early is corrupt.
io::Result<Raster<Rgba8>> decodeImage(std::span<const std::byte> bytes, int width, int height);

struct ImageHeader {
  ImageFormat format = ImageFormat::png;
  int width = 0;
  int height = 0;
};
/// What a picture says about itself, before any of its pixels is decoded.
io::Result<ImageHeader> readImageHeader(std::span<const std::byte> bytes);

}  // namespace tellurion::raster
