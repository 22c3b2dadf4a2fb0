#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "tiling/tiling.h"

namespace tellurion::scene {

/// Tells the place of a tile's corner from all others: the same in every tile that has a corner there. Never 0.
using CornerKey = std::uint64_t;

/// In the order of quadrants: (s, t) = (0, 0), (1, 0), (0, 1), (1, 1).
using TileCorners = std::array<CornerKey, 4>;
TileCorners tileCorners(const tiling::Tiling& tiling, const tiling::TileId& id);

/// How far tiles have left their parents' surfaces (0..1, DrawnTile::morph) at the corners where they meet: for each
/// corner and level one number, so that tiles of a level which share an edge morph alike (docs/selection.md). At a
/// corner where two levels meet, the coarser is at 1, what the finer starts from; the finer goes to 0, the coarser's
/// surface. Elsewhere it is what the finest tiles there ask for.
class CornerLattice {
 public:
  /// Where the corners of a tile are kept, until clear().
  using Places = std::array<std::uint32_t, 4>;

  /// A leaf of the cut.
  struct Leaf {
    tiling::TileId id;
    /// Those not drawn count as finer neighbours but not as coarser ones: how coarse the ground out of view is must not
    /// show.
    bool drawn = true;
    std::uint8_t coarseEdges = 0;  ///< bit e: what is drawn across tiling::Edge e is one level coarser
    bool isPart = false;           ///< drawn as a part of its parent's mesh
    bool fromParent = false;       ///< at the last frame the place was drawn by a coarser tile: new corners begin at 0
    float goal = 1.0f;
    float speed = 1.0f;  ///< how many times the usual step its values may take, >= 1
  };

  void clear();
  /// places, where they are asked for: filled in.
  void add(const TileCorners& corners, const Leaf& leaf, Places* places = nullptr);
  /// After all were added: values are where they should be; where there is a last frame that had the corner, no more
  /// than `step` times its speed from its value. Tells by how much more of that all would have reached their goals.
  float settle(const CornerLattice* last, float step);
  /// From here on values are by so much further on their way to their goals than settle() left them.
  void goOn(float steps) { gone_ = steps; }

  /// 0 where no tile of this level has the corner, 1 where finer ones have.
  float valueAt(CornerKey corner, int level) const;
  /// A tile finer than this level has the corner.
  bool hasFiner(CornerKey corner, int level) const;
  /// Of a tile that was added.
  std::array<float, 4> valuesAt(const Places& places, int level) const {
    return {valueIn(corners_[places[0]], level), valueIn(corners_[places[1]], level),
            valueIn(corners_[places[2]], level), valueIn(corners_[places[3]], level)};
  }
  /// The least that any of them is now, or will be on its way to its goal.
  float leastAt(const Places& places, int level) const {
    float least = 1.0f;
    for (const std::uint32_t place : places) {
      const Corner& c = corners_[place];
      if (level >= c.finest) least = std::min(least, level == c.finest ? std::min(valueOf(c), c.goal) : 0.0f);
    }
    return least;
  }

 private:
  struct Corner {
    CornerKey key = 0;
    std::int8_t finest = -1;
    std::int8_t coarsestDrawn = 127;
    bool fromParent = false;
    float goal = 0.0f;
    float speed = 1.0f;
    float value = 0.0f;
  };
  static constexpr std::uint32_t kFreeSlot = 0xFFFFFFFF;
  std::size_t slotOf(CornerKey key) const;
  std::uint32_t placeOf(CornerKey key);
  const Corner* find(CornerKey key) const;
  void meetCoarser(const Places& places, const Leaf& leaf);
  void grow();
  float valueOf(const Corner& c) const {
    return std::clamp(c.goal, c.value - gone_ * c.speed, c.value + gone_ * c.speed);
  }
  float valueIn(const Corner& corner, int level) const {
    if (level < corner.finest) return 1.0f;
    return level == corner.finest ? valueOf(corner) : 0.0f;
  }

  float gone_ = 0.0f;                 ///< since values were settled
  std::vector<Corner> corners_;       ///< clear() keeps its memory, and that of the slots
  std::vector<std::uint32_t> slots_;  ///< open addressing into corners_, half of them free
};

}  // namespace tellurion::scene
