#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tiling/tiling.h"

namespace tellurion::scene {

/// Tells the place of a tile's corner from all others: the same in every tile that has a corner there. Never 0.
using CornerKey = std::uint64_t;

struct TileCorners {
  std::array<CornerKey, 4> corners{};      ///< in the order of quadrants: (s, t) = (0, 0), (1, 0), (0, 1), (1, 1)
  std::array<CornerKey, 4> edgeMiddles{};  ///< where two finer tiles may have corners
};
TileCorners tileCorners(const tiling::Tiling& tiling, const tiling::TileId& id);

/// How far tiles have left their parents' surfaces (0..1, DrawnTile::morph) at the corners where they meet: for each
/// corner and level one number, so that tiles of a level which share an edge morph alike (docs/selection.md). At a
/// corner where two levels meet, the coarser is at 1, what the finer starts from; the finer goes to 0, the coarser's
/// surface. Elsewhere it is what the finest tiles there ask for.
class CornerLattice {
 public:
  void clear();
  /// A leaf of the cut. Those not drawn count as finer neighbours but not as coarser ones: how coarse the ground out of
  /// view is must not show.
  /// fromParent: at the last frame the place was drawn by a coarser tile, so corners that are new begin at 0.
  /// speed: how many times the usual step its values may take, >= 1.
  void add(const TileCorners& tile, int level, bool drawn, bool fromParent, float goal, float speed = 1.0f);
  /// After all were added: values are where they should be; where there is a last frame that had the corner, no more
  /// than `step` times its speed from its value. False: some have not reached their goal.
  bool settle(const CornerLattice* last, float step);

  /// 0 where no tile of this level has the corner, 1 where finer ones have.
  float valueAt(CornerKey corner, int level) const;

 private:
  static constexpr CornerKey kFreeSlot = 0;
  struct Corner {
    CornerKey key = kFreeSlot;
    std::int8_t finest = -1;
    std::int8_t coarsestDrawn = 127;
    bool fromParent = false;
    float goal = 0.0f;
    float speed = 1.0f;
    float value = 0.0f;
  };
  Corner& at(CornerKey key);
  const Corner* find(CornerKey key) const;
  void grow();
  static float valueIn(const Corner& corner, int level);

  std::vector<Corner> slots_;  ///< open addressing; clear() keeps its memory
  std::size_t used_ = 0;
};

}  // namespace tellurion::scene
