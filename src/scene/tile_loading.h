#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "io/executor.h"
#include "scene/tile_fetching.h"
#include "scene/tile_forest.h"

namespace tellurion::scene {

/// Where workers leave what they have made. Thread-safe.
class Arrivals {
 public:
  struct Arrival {
    tiling::TileId id;
    std::shared_ptr<const TileContent> content;  ///< null: more has to be fetched first
  };

  void add(Arrival arrival);
  std::vector<Arrival> take();

 private:
  std::mutex mutex_;
  std::vector<Arrival> waiting_;
};

/// A tile that is asked for: its sources' data are fetched, which takes no worker, then its content is made on one.
struct TileJob {
  struct Part {
    TileNeed need;
    std::shared_ptr<TileFetch> fetch;  ///< null: there is nothing to wait for
  };
  std::vector<Part> missing;  ///< still on their way
  std::vector<Part> fetched;
  std::vector<LayerTiles::TilePointer> kept;  ///< needed and here already: stays until the content is made
  bool isStandIn = false;                     ///< of a root: pictures that have not come yet are not waited for
  bool isShort = false;                       ///< what failed to load makes other tiles needed
  bool submitted = false;
  double priority = 0.0;  ///< of the task, once that is submitted
  /// Worker and globe share it: whoever is first decides whether the task runs.
  std::atomic<bool> taken{false};
  io::Executor::Task task;
};

/// Brings what a forest's tiles are made of and has workers make them, the most urgent first. One thread only; ends
/// after the executor's threads.
class TileLoading {
 public:
  TileLoading(TileForest& forest, io::Executor& executor, TileFetches& fetches, Doorbell& bell)
      : forest_(forest), executor_(executor), fetches_(fetches), bell_(bell) {}
  TileLoading(const TileLoading&) = delete;
  TileLoading& operator=(const TileLoading&) = delete;

  /// Hands over to the forest what workers have made. False: nothing.
  bool receive();
  /// What is wanted now, the most urgent first, and what will be soon, which is less urgent. What is on its way gets
  /// its new priority, and what is not wanted any more is cancelled: transfers stop, and what no worker has begun never
  /// is.
  void request(std::span<const WantedTile> wanted, std::span<const WantedTile> soon);
  /// What is on its way from servers goes on, for whoever asks for it too; nothing is made.
  void pause();
  /// Nothing is wanted any more.
  void stop();
  bool isIdle() const { return underway_.empty(); }

 private:
  void request(std::span<const WantedTile> wanted);
  void begin(const WantedTile& wanted, TileRecord& record);
  void fetchNeeds(const WantedTile& wanted, const TileRecord& record);
  bool advance(const WantedTile& wanted, TileRecord& record);
  void submit(const WantedTile& wanted, TileRecord& record);
  template <class IsUnwanted>
  void cancel(const IsUnwanted& isUnwanted);

  TileForest& forest_;
  io::Executor& executor_;
  TileFetches& fetches_;
  Doorbell& bell_;
  std::vector<TileNeed> needs_;  ///< of one tile: memory that is kept
  int begun_ = 0;                ///< in this request
  std::vector<tiling::TileId> underway_;
  Arrivals arrivals_;
};

}  // namespace tellurion::scene
