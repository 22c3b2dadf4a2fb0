#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tiling/tiling.h"

namespace tellurion::scene {

/// Tells the place of a tile's corner from all others: the same in every tile that has a corner there.
using CornerKey = std::uint64_t;

/// Where all tiles of a row meet at a pole of the geographic tiling, however different their levels: no corner to agree
/// upon, its value is always 1.
inline constexpr CornerKey kPoleCorner = 0;

/// In the order of quadrants: (s, t) = (0, 0), (1, 0), (0, 1), (1, 1).
std::array<CornerKey, 4> cornerKeys(const tiling::Tiling& tiling, const tiling::TileId& id);

/// How far tiles have left their parents' surfaces (0..1, DrawnTile::morph) at the corners where they meet: for each
/// corner and level one number, so that tiles of a level which share an edge morph alike (docs/selection.md). At a
/// corner where two levels meet, the coarser is at 1, what the finer starts from; the finer goes to 0, the coarser's
/// surface. Elsewhere it is what the finest tiles there ask for.
///
/// Values of the last frame may be kept to limit how fast they change.
class CornerLattice {
 public:
  /// Forgets all tiles, and keeps the values as those of the last frame.
  void begin();
  /// A leaf of the cut. Those not drawn count as finer neighbours but not as coarser ones: how coarse the ground out of
  /// view is must not show.
  void add(const std::array<CornerKey, 4>& corners, int level, bool drawn, float goal);
  /// After all were added: values move to where they should be, by no more than `step` from the last frame's.
  void settle(float step);

  float valueAt(CornerKey corner, int level) const;
  bool isMoving() const { return moving_; }  ///< some value has not reached its goal
  /// Of the last frame: 0 where no tile of this level had the corner, 1 where finer ones had.
  float lastAt(CornerKey corner, int level) const;
  void forget();  ///< also the last frame

 private:
  struct Corner {
    CornerKey key = 0;  ///< 0: free
    std::int8_t finest = -1;
    std::int8_t coarsestDrawn = 127;
    float goal = 0.0f;
    float value = 0.0f;
  };
  class Table {  // open addressing; its memory is kept from frame to frame
   public:
    Corner& at(CornerKey key);
    const Corner* find(CornerKey key) const;
    void clear();
    template <class Visit>
    void forEach(const Visit& visit);

   private:
    void grow();
    std::vector<Corner> slots_;
    std::size_t used_ = 0;
  };
  static float valueIn(const Corner& corner, int level);

  Table now_;
  Table last_;
  bool moving_ = false;
};

}  // namespace tellurion::scene
