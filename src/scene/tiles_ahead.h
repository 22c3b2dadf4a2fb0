#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "scene/cut_growth.h"
#include "scene/tile_forest.h"

namespace tellurion::scene {

/// What a view that is expected soon will want of a forest. One thread only.
class TilesAhead {
 public:
  /// Cuts for `expected`, where there is such a view, at most ten times a second by the options' clock, in each update
  /// as much of the cut as its share of the time, at most a quarter: so no frame takes longer than others for it. After
  /// the cut for what is drawn, in the same update of the forest, always the same one.
  void look(const std::optional<View>& expected, const CutOptions& options, TileForest& forest);
  /// Of that what is not here yet and can be asked for, the most urgent first, all less urgent than anything that a
  /// picture wants; a few dozen at most. Valid until the next call.
  std::span<const WantedTile> wanted(const TileForest& forest);
  /// The number of the forest's update since which all that was used must stay: the cut in hand has begun in it.
  std::uint64_t neededSince() const { return cut_ ? cut_->begunIn : std::numeric_limits<std::uint64_t>::max(); }

 private:
  /// A cut in hand.
  struct Cut {
    CutOptions options;
    CutSight sight;
    std::uint64_t begunIn = 0;  ///< update of the forest
  };
  void begin(const View& expected, const CutOptions& options, TileForest& forest);
  void goOn(double share, TileForest& forest);

  std::optional<Cut> cut_;
  GrowthBuffers growth_;
  Selection out_;
  std::size_t steps_ = 0;                                            ///< of the cut in hand, so far
  std::size_t lastSteps_ = std::numeric_limits<std::size_t>::max();  ///< of the one before
  std::vector<WantedTile> found_;
  std::vector<WantedTile> wanted_;
  std::optional<double> begun_s_;  ///< when the last cut was begun
  std::optional<double> lookedAt_s_;
};

}  // namespace tellurion::scene
