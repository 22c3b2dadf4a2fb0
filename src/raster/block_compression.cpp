#include "raster/block_compression.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <span>

#define STB_DXT_STATIC
#define STB_DXT_IMPLEMENTATION
#include <stb/stb_dxt.h>

namespace tellurion::raster {
namespace {

constexpr int kSide = 4;
constexpr std::size_t kColourBytes = 8;    // the whole of a bc1 block, the second half of a bc3 block
constexpr std::size_t kCoverageBytes = 8;  // the first half of a bc3 block
using Block = std::array<Rgba8, kSide * kSide>;

int blocksAlong(int pixels) {
  return (pixels + kSide - 1) / kSide;
}

std::size_t bytesABlock(BlockFormat format) {
  return format == BlockFormat::bc1 ? kColourBytes : kCoverageBytes + kColourBytes;
}

/// Beyond the picture its last column and row go on.
Block blockAt(const Raster<Rgba8>& picture, int left, int top) {
  Block block;
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col)
      block[static_cast<std::size_t>(row * kSide + col)] =
          picture.at(std::min(left + col, picture.width - 1), std::min(top + row, picture.height - 1));
  }
  return block;
}

unsigned int littleEndian(std::span<const std::byte> bytes) {
  unsigned int value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;)
    value = value << 8u | std::to_integer<unsigned int>(bytes[i]);
  return value;
}

Rgba8 colourOf565(unsigned int v) {
  const unsigned int r = v >> 11u & 31u;
  const unsigned int g = v >> 5u & 63u;
  const unsigned int b = v & 31u;
  return {static_cast<std::uint8_t>(r << 3u | r >> 2u), static_cast<std::uint8_t>(g << 2u | g >> 4u),
          static_cast<std::uint8_t>(b << 3u | b >> 2u), 255};
}

/// (a * share + b * (of - share)) / of, channel by channel.
Rgba8 between(Rgba8 a, Rgba8 b, int share, int of) {
  const auto mixed = [&](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>((x * share + y * (of - share)) / of);
  };
  return {mixed(a.r, b.r), mixed(a.g, b.g), mixed(a.b, b.b), 255};
}

void readColours(std::span<const std::byte, kColourBytes> bytes, bool mayHaveThree, Block& block) {
  const unsigned int first = littleEndian(bytes.subspan<0, 2>());
  const unsigned int second = littleEndian(bytes.subspan<2, 2>());
  std::array<Rgba8, 4> palette{colourOf565(first), colourOf565(second)};
  const bool hasFour = first > second || !mayHaveThree;
  palette[2] = hasFour ? between(palette[0], palette[1], 2, 3) : between(palette[0], palette[1], 1, 2);
  palette[3] = hasFour ? between(palette[0], palette[1], 1, 3) : Rgba8{0, 0, 0, 255};
  unsigned int choices = littleEndian(bytes.subspan<4, 4>());
  for (Rgba8& pixel : block) {
    pixel = palette[choices & 3u];
    choices >>= 2u;
  }
}

void readCoverage(std::span<const std::byte, kCoverageBytes> bytes, Block& block) {
  const auto first = std::to_integer<int>(bytes[0]);
  const auto second = std::to_integer<int>(bytes[1]);
  std::array<int, 8> palette{first, second, 0, 0, 0, 0, 0, 255};
  const int steps = first > second ? 7 : 5;
  for (int i = 1; i < steps; ++i)
    palette[static_cast<std::size_t>(i + 1)] = (first * (steps - i) + second * i) / steps;
  for (std::size_t half = 0; half < 2; ++half) {
    unsigned int choices = littleEndian(bytes.subspan(2 + 3 * half, 3));
    for (std::size_t i = 8 * half; i < 8 * half + 8; ++i) {
      block[i].a = static_cast<std::uint8_t>(palette[choices & 7u]);
      choices >>= 3u;
    }
  }
}

}  // namespace

std::uint64_t blockBytes(BlockFormat format, int width, int height) {
  return std::uint64_t{bytesABlock(format)} * static_cast<std::uint64_t>(blocksAlong(width)) *
         static_cast<std::uint64_t>(blocksAlong(height));
}

BlockPicture compressed(const Raster<Rgba8>& picture, BlockFormat format) {
  assert(picture.width >= 1 && picture.height >= 1);
  BlockPicture out{.format = format, .width = picture.width, .height = picture.height, .bytes = {}};
  out.bytes.resize(blockBytes(format, picture.width, picture.height));
  auto* to = reinterpret_cast<unsigned char*>(out.bytes.data());
  for (int top = 0; top < picture.height; top += kSide) {
    for (int left = 0; left < picture.width; left += kSide) {
      const Block block = blockAt(picture, left, top);
      stb_compress_dxt_block(to, &block[0].r, format == BlockFormat::bc3 ? 1 : 0, STB_DXT_HIGHQUAL);
      to += bytesABlock(format);
    }
  }
  return out;
}

Raster<Rgba8> decompressed(const BlockPicture& picture) {
  assert(picture.bytes.size() == blockBytes(picture.format, picture.width, picture.height));
  Raster<Rgba8> out(picture.width, picture.height);
  std::span<const std::byte> bytes = picture.bytes;
  for (int top = 0; top < picture.height; top += kSide) {
    for (int left = 0; left < picture.width; left += kSide) {
      Block block;
      const bool hasCoverage = picture.format == BlockFormat::bc3;
      readColours(bytes.subspan(hasCoverage ? kCoverageBytes : 0).first<kColourBytes>(), !hasCoverage, block);
      if (hasCoverage) readCoverage(bytes.first<kCoverageBytes>(), block);
      bytes = bytes.subspan(bytesABlock(picture.format));
      for (int row = top; row < std::min(top + kSide, picture.height); ++row) {
        for (int col = left; col < std::min(left + kSide, picture.width); ++col)
          out.at(col, row) = block[static_cast<std::size_t>((row - top) * kSide + col - left)];
      }
    }
  }
  return out;
}

}  // namespace tellurion::raster
