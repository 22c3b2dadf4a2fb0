#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "scene/select.h"
#include "scene/tile_loading.h"
#include "scene/tiles_ahead.h"

namespace tellurion::scene {

/// The planet out of one set of layers: its tiles, what of them is here and on its way, and the cut through them. When
/// a layer joins, the ground of all tiles may be another, so another generation begins. One thread only.
class Generation {
 public:
  /// groundIsNested: as CutOptions::isNested, of these layers.
  Generation(ContentMaker maker, bool groundIsNested, io::Executor& executor, TileFetches& fetches, Doorbell& bell)
      : forest(std::move(maker)),
        loading(forest, executor, fetches, bell),
        groundIsNested_(groundIsNested),
        selector_(forest.maker().tiling, forest.maker().ellipsoid) {}

  TileForest forest;
  TileLoading loading;
  TilesAhead ahead;

  /// Takes in what has been made and cuts. Valid until the next call.
  const Selection& cut(const View& view, const CutOptions& options, double exaggeration,
                       std::span<const LayerLook> looks, const Residency* gpu);
  /// After the cut and looking ahead: drops tiles until contents take no more than that, but none that these need.
  void evict(std::uint64_t budgetBytes) { forest.evict(budgetBytes, ahead.neededSince()); }
  /// Of the last cut, as Selection has them; empty before the first.
  std::span<const double> rootShares() const { return rootShares_; }
  /// All of them can be drawn, so the surface is whole.
  bool rootsAreDrawable() const;
  /// Roots that may be seen still lack pictures.
  bool lacksRoots() const;
  /// When cut() took in the last tile; before the first of all times.
  std::chrono::steady_clock::time_point lastArrival() const { return lastArrival_; }
  /// The layers, each once, whose data tiles of the last cut wait for.
  std::vector<const LayerTiles*> waitedFor() const;

 private:
  const CutHistory* historyAt(const CutOptions& options);

  bool groundIsNested_;
  Selector selector_;
  const Selection* lastCut_ = nullptr;
  std::chrono::steady_clock::time_point lastArrival_;
  std::vector<double> rootShares_;     ///< Selection's of the last cut
  std::array<CutMemory, 2> memories_;  ///< of the last time and of this one; which is which, history says
  CutHistory history_{.last = &memories_[0], .now = &memories_[1]};
  std::optional<double> time_s_;      ///< of memories' newer one
  std::optional<double> lastTime_s_;  ///< and of the older
};

}  // namespace tellurion::scene
