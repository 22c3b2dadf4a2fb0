#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <vector>

#include "io/executor.h"
#include "scene/tile_forest.h"

namespace tellurion::scene {

/// Where workers leave what they have made. Thread-safe.
class Arrivals {
 public:
  struct Arrival {
    tiling::TileId id;
    std::shared_ptr<const TileContent> content;
  };

  void add(Arrival arrival);
  std::vector<Arrival> take();
  /// Sleeps until there is something to take. False: the time is over.
  bool wait(std::chrono::milliseconds timeout);

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Arrival> waiting_;
};

/// A task's state that worker and globe share: whoever is first decides whether it runs.
struct TileJob {
  std::atomic<bool> taken{false};
  io::Executor::Task task;
};

/// Has workers make the contents of tiles that a forest wants, the most urgent first. One thread only; must outlive the
/// executor's threads.
class TileLoading {
 public:
  TileLoading(TileForest& forest, io::Executor& executor) : forest_(forest), executor_(executor) {}
  TileLoading(const TileLoading&) = delete;
  TileLoading& operator=(const TileLoading&) = delete;

  /// Hands over to the forest what workers have made.
  void receive();
  /// What is wanted now. What is on its way gets its new priority, and what is not wanted any more is cancelled unless
  /// it has begun.
  void request(const std::vector<WantedTile>& wanted);
  bool isIdle() const { return underway_.empty(); }
  bool wait(std::chrono::milliseconds timeout) { return arrivals_.wait(timeout); }

 private:
  void submit(const WantedTile& wanted, TileRecord& record);
  void cancelUnwanted();

  TileForest& forest_;
  io::Executor& executor_;
  std::vector<tiling::TileId> underway_;
  Arrivals arrivals_;
};

}  // namespace tellurion::scene
