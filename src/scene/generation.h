#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
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

  /// Takes in what has been made and cuts, or keeps the last cut, where that may be and is right for this view too:
  /// with a clock it is made for the views around one (Leeway). Then nothing was looked at and nothing has to be asked
  /// for, and of its tiles only how they morph has changed. hasCome: something that was asked for may have. Valid until
  /// the next call.
  const Selection& cut(const View& view, const CutOptions& options, double exaggeration,
                       std::span<const LayerLook> looks, const Residency* gpu, bool mayKeep, bool hasCome);
  /// How many updates ago the last cut was made, 0 in the one that made it.
  int age() const { return age_; }
  /// The last cut was made for views around that of the last update as well; for the same view, the first update with a
  /// later time makes another.
  bool hasLeeway() const { return made_ && (made_->leeway.move_m > 0.0 || made_->leeway.turn > 0.0); }
  /// Something has come since the last cut that it may have waited for: one of the next updates takes it up.
  bool isBehind() const { return lastCut_ != nullptr && ((hasArrivals_ && !isSettled()) || isRenewed()); }
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
  void receive();
  bool canKeep(const View& view, const CutOptions& options, double exaggeration, std::span<const LayerLook> looks,
               const Residency* gpu) const;
  const CutHistory* historyFor(const View& view, const CutOptions& options);
  bool isSettled() const { return lastCut_->wanted.empty() && !lastCut_->morphing && loading.isIdle(); }
  bool isRenewed() const { return madeRenewals_ != forest.renewals(); }
  void tellTime(const View& view, const CutOptions& options);

  bool groundIsNested_;
  Selector selector_;
  const Selection* lastCut_ = nullptr;
  std::chrono::steady_clock::time_point lastArrival_;
  std::vector<double> rootShares_;                      ///< Selection's of the last cut
  std::array<CutMemory, 2> memories_;                   ///< of cuts, the newer second
  std::array<std::optional<double>, 2> memoryTimes_s_;  ///< when they were made
  CutHistory history_{.last = &memories_[0], .now = &memories_[1]};
  /// An update's view and the scene's clock.
  struct Moment {
    View view;
    double time_s = 0.0;
  };
  std::optional<Moment> now_;
  std::optional<Moment> before_;  ///< the last at another time
  /// What the last cut was made for; nothing where it had no history.
  struct Made {
    View view;
    CutOptions options;
    Leeway leeway;
  };
  std::optional<Made> made_;
  int age_ = 0;
  bool hasArrivals_ = false;        ///< since the last cut
  std::uint64_t madeRenewals_ = 0;  ///< TileForest's, at the last cut: what has new pictures may need other tiles
};

}  // namespace tellurion::scene
