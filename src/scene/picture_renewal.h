#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "scene/tile_loading.h"

namespace tellurion::scene {

/// Brings the pictures of layers that follow the clock to its time step, tile by tile: a tile keeps its old picture
/// until the new one is made, and all else of it stays. One thread only; must end before its executor does, or after
/// its threads; never waits.
class PictureRenewal {
 public:
  /// colours: of the forest that update() is given.
  PictureRenewal(const ColourLayers& colours, io::Executor& executor, TileFetches& fetches, Doorbell& bell);
  ~PictureRenewal();
  PictureRenewal(const PictureRenewal&) = delete;
  PictureRenewal& operator=(const PictureRenewal&) = delete;

  /// After the cut: exchanges what has been made, as far as copies to the GPU are left (spareCopies_bytes, from which
  /// it is taken; one in any case), and has more made of what is drawn and out of date. upcoming: of steps to come,
  /// loaded ahead while nothing is out of date; more of them is asked for only when all that shows is here.
  void update(TileForest& forest, const std::vector<SelectedTile>& drawn, const Residency* gpu,
              std::uint64_t& spareCopies_bytes, const std::vector<std::shared_ptr<LayerTiles>>& upcoming,
              bool allIsHere);
  /// Drawn tiles whose pictures are of an older step.
  int outOfDate() const { return outOfDate_; }
  /// Of those, and of what they need, the ones that only wait for their copy.
  int heldBack() const { return static_cast<int>(made_.size()); }

 private:
  struct Made {
    tiling::TileId id;
    std::shared_ptr<const TileContent> from;
    std::shared_ptr<const TileContent> content;
  };
  struct Arrivals;

  std::vector<tiling::TileId> staleTiles(const TileForest& forest, const std::vector<SelectedTile>& drawn);
  void addStale(const TileForest& forest, const tiling::TileId& id, std::vector<tiling::TileId>& stale);
  bool exchange(TileForest& forest, const tiling::TileId& id, const Residency* gpu, std::uint64_t& spare_bytes,
                bool mayExceed);
  void make(TileForest& forest, const tiling::TileId& id);
  void submit(const TileForest& forest, const tiling::TileId& id, const std::shared_ptr<const TileContent>& content);
  void begin(const tiling::TileId& id, TileJob& job);
  bool canBegin(const TileForest& forest, const tiling::TileId& id, const TileContent& content) const;
  void forget(const std::vector<tiling::TileId>& stale);
  void restart();
  void loadAhead(const TileForest& forest, const std::vector<SelectedTile>& drawn,
                 const std::vector<std::shared_ptr<LayerTiles>>& upcoming, bool allIsHere);

  std::shared_ptr<const ColourLayers> colours_;
  io::Executor& executor_;
  TileFetches& fetches_;
  Doorbell& bell_;
  std::shared_ptr<Arrivals> arrivals_;
  std::unordered_map<tiling::TileId, std::shared_ptr<TileJob>, tiling::TileIdHash> jobs_;
  std::unordered_map<tiling::TileId, Made, tiling::TileIdHash> made_;
  std::unordered_set<tiling::TileId, tiling::TileIdHash> listed_;  ///< of staleTiles(): memory that is kept
  std::vector<TileNeed> needs_;                                    ///< likewise
  std::vector<std::uint64_t> editions_;                            ///< that jobs were begun for
  int outOfDate_ = 0;

  /// What is loaded ahead of one step: each tile once.
  struct Ahead {
    std::shared_ptr<LayerTiles> tiles;
    std::unordered_set<tiling::TileId, tiling::TileIdHash> asked;
    struct Load {
      tiling::TileId id;
      std::shared_ptr<TileFetch> fetch;
      io::Executor::Task task;
      std::shared_ptr<std::atomic<bool>> done;
    };
    std::vector<Load> loads;
  };
  void advance(Ahead& ahead);
  void askAhead(Ahead& ahead, const tiling::TileId& id);
  std::vector<Ahead> ahead_;
};

}  // namespace tellurion::scene
