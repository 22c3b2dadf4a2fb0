#pragma once

#include <optional>
#include <span>
#include <vector>

#include "scene/tile_forest.h"

namespace tellurion::scene {

/// What a view that is expected soon will want of a forest. One thread only.
class TilesAhead {
 public:
  TilesAhead(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid) : selector_(tiling, ellipsoid) {}

  /// Cuts for `expected`, where there is such a view, ten times a second by the options' clock. After the cut for what
  /// is drawn, in the same update of the forest.
  void look(const std::optional<View>& expected, const CutOptions& options, TileForest& forest);
  /// Of that what is not here yet and can be asked for, the most urgent first, all less urgent than anything that a
  /// picture wants; a few dozen at most. Valid until the next call.
  std::span<const WantedTile> wanted(const TileForest& forest);

 private:
  Selector selector_;
  std::vector<WantedTile> found_;
  std::vector<WantedTile> wanted_;
  std::optional<double> lookedAt_s_;
};

}  // namespace tellurion::scene
