#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/failure.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// A row of the table of tiles: a tile at rest, its payload encoded. Every byte is described in docs/tile-database.md.
struct TileRecord {
  tiling::TileId id;
  raster::HeightStatistics statistics;
  std::uint8_t childMask = 0;
  std::array<raster::HeightStatistics, 4> children{};
  std::vector<std::byte> payload;
  std::vector<std::byte> depths;  ///< elevation: what the table of fills tells of the tile; empty: nothing
};

/// The row's number: a one, the root in four bits, then the bits of y and x interleaved, x lowest. Tiles of one level
/// lie together, coarser levels first, neighbours near each other. Always positive.
std::int64_t rowNumberOf(const tiling::TileId& id);
/// Nothing for a number that belongs to no tile (roots up to 15 are let through: the tiling decides).
std::optional<tiling::TileId> tileOfRowNumber(std::int64_t number);
/// The numbers of a level: [first, last].
struct RowRange {
  std::int64_t first;
  std::int64_t last;
};
RowRange rowsOfLevel(int level);

/// The children's statistics as they are stored: 12 float32, little-endian, a missing child's minimum and maximum NaN.
inline constexpr std::size_t kChildrenBytes = 48;
std::vector<std::byte> childrenBytes(const std::array<raster::HeightStatistics, 4>& children);
std::array<raster::HeightStatistics, 4> childrenFromBytes(std::span<const std::byte, kChildrenBytes> bytes);

/// CRC-32 (ISO-HDLC, as in zlib, PNG and gzip) of the row's other columns and the payload.
std::uint32_t checksumOf(const TileRecord& record, raster::Kind kind);

/// "tile 5/2/17/9": level, root, x, y.
std::string nameOf(const tiling::TileId& id);

/// The payload decoded. Safe on untrusted bytes.
io::Result<raster::SourceTile> decoded(const TileRecord& record, raster::Kind kind, int tileCells);

}  // namespace tellurion::pyramid
