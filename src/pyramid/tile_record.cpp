#include "pyramid/tile_record.h"

#include <fmt/format.h>

#include <bit>
#include <cassert>

#include "io/crc32.h"
#include "raster/codec.h"
#include "tiling/morton.h"

namespace tellurion::pyramid {
namespace {

constexpr int kRootBits = 4;

void appendLittleEndian(std::vector<std::byte>& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i)
    out.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xffu));
}

/// One NaN for all, so that a checksum does not depend on which one the processor made.
void appendFloat(std::vector<std::byte>& out, float value) {
  appendLittleEndian(out, std::bit_cast<std::uint32_t>(raster::isNoData(value) ? raster::kNoData : value), 4);
}

void appendStatistics(std::vector<std::byte>& out, const raster::HeightStatistics& statistics) {
  appendFloat(out, statistics.min_m);
  appendFloat(out, statistics.max_m);
  appendFloat(out, statistics.error_m);
}

float floatAt(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < 4; ++i)
    bits |= std::to_integer<std::uint32_t>(bytes[offset + i]) << (8 * i);
  return std::bit_cast<float>(bits);
}

}  // namespace

std::int64_t rowNumberOf(const tiling::TileId& id) {
  assert(id.level <= tiling::kMaxLevel && id.root < (1 << kRootBits));
  const std::uint64_t prefix = (std::uint64_t{1} << kRootBits) | id.root;
  return static_cast<std::int64_t>((prefix << (2u * id.level)) | tiling::interleaved(id.x, id.y));
}

std::optional<tiling::TileId> tileOfRowNumber(std::int64_t number) {
  if (number < (1 << kRootBits)) return std::nullopt;
  const auto bits = static_cast<std::uint64_t>(number);
  const int width = static_cast<int>(std::bit_width(bits)) - 1 - kRootBits;
  if (width % 2 != 0 || width / 2 > tiling::kMaxLevel) return std::nullopt;
  const std::uint64_t mask = (std::uint64_t{1} << static_cast<unsigned>(width)) - 1;
  tiling::TileId id;
  id.level = static_cast<std::uint8_t>(width / 2);
  id.root = static_cast<std::uint8_t>((bits >> static_cast<unsigned>(width)) & ((1u << kRootBits) - 1));
  id.x = tiling::evenBits(bits & mask);
  id.y = tiling::evenBits((bits & mask) >> 1u);
  return id;
}

RowRange rowsOfLevel(int level) {
  const std::int64_t first = std::int64_t{1} << (kRootBits + 2 * level);
  return {first, first + (first - 1)};
}

std::vector<std::byte> childrenBytes(const std::array<raster::HeightStatistics, 4>& children) {
  std::vector<std::byte> bytes;
  bytes.reserve(kChildrenBytes);
  for (const raster::HeightStatistics& child : children)
    appendStatistics(bytes, child);
  return bytes;
}

std::array<raster::HeightStatistics, 4> childrenFromBytes(std::span<const std::byte, kChildrenBytes> bytes) {
  std::array<raster::HeightStatistics, 4> children;
  for (std::size_t q = 0; q < 4; ++q) {
    children[q] = {floatAt(bytes, 12 * q), floatAt(bytes, 12 * q + 4), floatAt(bytes, 12 * q + 8)};
  }
  return children;
}

std::uint32_t checksumOf(const TileRecord& record, raster::Kind kind) {
  std::vector<std::byte> header;
  appendLittleEndian(header, static_cast<std::uint64_t>(rowNumberOf(record.id)), 8);
  appendLittleEndian(header, record.childMask, 1);
  if (kind == raster::Kind::elevation) {
    appendStatistics(header, record.statistics);
    for (const raster::HeightStatistics& child : record.children)
      appendStatistics(header, child);
  }
  io::Crc32 crc;
  crc.add(header);
  crc.add(record.payload);
  return crc.value();
}

std::string nameOf(const tiling::TileId& id) {
  return fmt::format("tile {}/{}/{}/{}", id.level, id.root, id.x, id.y);
}

io::Result<raster::SourceTile> decoded(const TileRecord& record, raster::Kind kind, int tileCells) {
  raster::SourceTile tile;
  tile.statistics = record.statistics;
  tile.childMask = record.childMask;
  tile.children = record.children;
  if (kind == raster::Kind::elevation) {
    const int side = tileCells + 1 + 2 * raster::kGutter;
    auto samples = raster::decodeElevation(record.payload, side, side);
    if (!samples) return tl::unexpected(std::move(samples).error());
    tile.payload = raster::ElevationTile{std::move(*samples)};
  } else {
    const int side = tileCells + 2 * raster::kGutter;
    auto pixels = raster::decodeImage(record.payload, side, side);
    if (!pixels) return tl::unexpected(std::move(pixels).error());
    tile.payload = raster::ImageryTile{std::move(*pixels)};
  }
  return tile;
}

}  // namespace tellurion::pyramid
