#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/failure.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// Which tiles a database stores: a byte a tile, its mask of children, levels from the roots down, each in the order of
/// row numbers. Plain data once made; any number of threads may ask.
class TileIndex {
 public:
  /// More are not taken.
  static constexpr std::uint64_t kMostTiles = std::uint64_t{1} << 26;

  /// roots: bit r set: root r is stored.
  explicit TileIndex(std::uint32_t roots = 0) : roots_(roots) {}
  /// The masks of the next level; how many that must be: nextCount().
  void addLevel(std::vector<std::uint8_t> masks);
  std::uint64_t nextCount() const;

  std::uint32_t roots() const { return roots_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  std::span<const std::uint8_t> masksOf(int level) const { return levels_[static_cast<std::size_t>(level)].masks; }
  raster::TilePresence find(const tiling::TileId& id) const;

 private:
  static constexpr std::size_t kBlock = 64;
  struct Level {
    std::vector<std::uint8_t> masks;
    std::vector<std::uint64_t> before;  ///< children of the tiles before each block; one more: of all
  };
  std::uint32_t roots_ = 0;
  std::vector<Level> levels_;
};

/// As runs: of each level in turn a mask and, in groups of seven bits, lowest first, how many tiles it is of. Four
/// bytes of roots go before, lowest first.
std::vector<std::byte> encodedIndex(const TileIndex& index);
/// levels: that there must be. Safe on untrusted bytes.
io::Result<TileIndex> decodedIndex(std::span<const std::byte> bytes, int levels, int rootCount);

}  // namespace tellurion::pyramid
