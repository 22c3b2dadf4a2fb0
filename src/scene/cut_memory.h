#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scene/corner_lattice.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// What a frame drew, for the next one to go on from without a jump. One thread.
class CutMemory {
 public:
  enum class Was : std::uint8_t { leaf, split };

  CornerLattice corners;

  void clear();
  /// Each tile once: leaves that were drawn, and what is over them as split.
  void add(const tiling::TileId& id, Was was);
  std::optional<Was> find(const tiling::TileId& id) const;

 private:
  struct Slot {
    tiling::TileId id{.level = kFree};
    Was was = Was::leaf;
  };
  static constexpr std::uint8_t kFree = 255;  ///< no level
  std::size_t slotOf(const tiling::TileId& id) const;
  void grow();

  std::vector<Slot> slots_;  ///< open addressing; clear() keeps its memory
  std::size_t used_ = 0;
};

}  // namespace tellurion::scene
