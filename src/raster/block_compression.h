#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "raster/raster.h"

/// Pictures as GPUs read them compressed, in blocks of 4 x 4 pixels. All functions are thread-safe.
namespace tellurion::raster {

/// bc1: 8 bytes a block, colour only; bc3: 16, and coverage. Also known as DXT1 and DXT5
/// (EXT_texture_compression_s3tc).
enum class BlockFormat : std::uint8_t { bc1, bc3 };

/// Rows of blocks from the top, each row from the left; the last ones reach beyond the picture where a side is no
/// multiple of 4.
struct BlockPicture {
  BlockFormat format = BlockFormat::bc1;
  int width = 0;  ///< in pixels
  int height = 0;
  std::vector<std::byte> bytes;
};

/// Bytes of a compressed picture of this size.
std::uint64_t blockBytes(BlockFormat format, int width, int height);

/// With loss: a block has four colours on a line, of 5, 6 and 5 bits at its ends, and with bc3 eight values of
/// coverage. How far off real pictures come out is in docs/measurements.md. Sides >= 1. bc1 drops coverage.
BlockPicture compressed(const Raster<Rgba8>& picture, BlockFormat format);

/// As a GPU shows it. bc1 comes out covered all over. `bytes` must be blockBytes() long.
Raster<Rgba8> decompressed(const BlockPicture& picture);

}  // namespace tellurion::raster
