#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "tiling/tiling.h"

namespace tellurion::scene {

inline constexpr std::size_t kAround = 8;

/// The tiles of the same level that touch a tile: across its edges in the order of tiling::kEdges, then at its corners
/// in the order of tiling::kCorners (nothing where three tiles meet).
using TilesAround = std::array<std::optional<tiling::TileId>, kAround>;
TilesAround tilesAround(const tiling::Tiling& tiling, const tiling::TileId& id);

/// One of these, by its place, where it lies in the same root; nothing where it does not.
inline std::optional<tiling::TileId> besideInRoot(const tiling::TileId& id, std::size_t place) {
  constexpr std::array<std::uint32_t, kAround> kRight{0, 1, 0, ~0u, ~0u, 1, 1, ~0u};  // ~0u: one less
  constexpr std::array<std::uint32_t, kAround> kDown{~0u, 0, 1, 0, ~0u, ~0u, 1, 1};
  const std::uint32_t x = id.x + kRight[place];
  const std::uint32_t y = id.y + kDown[place];
  if (((x | y) >> id.level) != 0) return std::nullopt;
  return tiling::TileId{id.level, id.root, x, y};
}

/// Where a tile finds what touches it: a sibling, by its quadrant, or a child of what touches its parent, by the place
/// in TilesAround. It follows from its own quadrant alone, however roots are turned against each other.
struct Kin {
  bool isSibling = false;
  std::uint8_t which = 0;
};
Kin kinAround(int quadrant, std::size_t place);

}  // namespace tellurion::scene
