#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>

#include "pyramid/ordered_work.h"
#include "pyramid/shard.h"
#include "pyramid/tile_maker.h"
#include "pyramid/tile_walk.h"
#include "raster/block_cache.h"

namespace tellurion::pyramid {

/// What of a build a run does, where it is cut into parts (PartedBuild).
struct BuildCut {
  std::optional<tiling::TileId> part;  ///< only the pieces of the first level below this tile are made, and listed
  ShardSet* shards = nullptr;          ///< where the first level's pieces are taken from instead of being made
};

/// One run over an unfinished database: first the blocks of the deepest levels, each made whole in memory, where the
/// plan allows them; then level by level, tiles in the order of their rows, from what is stored. Committed in groups
/// whose borders depend on the plan alone. So a run that goes on after a kill makes the same groups, and the file the
/// same bytes. One thread only; its workers are its own.
class BuildRun {
 public:
  /// What a run may use; its result does not depend on it.
  struct Resources {
    int jobs = 1;
    std::uint64_t memoryBytes = 0;
  };
  BuildRun(const BuildPlan& plan, TileDatabase& database, const Resources& resources, const ProgressSink& progress,
           std::stop_token stop, const BuildCut& cut = {});

  /// From where the database says to the end of level 0, or of the first level for a part. Its last commit does not yet
  /// make the database complete.
  io::Result<void> run(BuildPosition start);

  /// What this run's inputs have warned of, whichever thread met it. After run() only.
  std::set<std::string> warnings() const;

 private:
  using Made = io::Result<MadeTiles>;

  io::Result<void> prepareBase();
  io::Result<void> runLevel();
  io::Result<void> submit(const Candidate& candidate);
  io::Result<TileTask> taskFor(const Candidate& candidate);
  io::Result<void> readBeyond(TileTask& task);
  io::Result<void> readDeeper(TileTask& task);
  io::Result<void> finishOldest();
  io::Result<void> take(const Candidate& candidate, const MadeTiles& made);
  io::Result<void> beginGroup();
  io::Result<void> commitGroup();
  TileMaker& makerOfThisThread();
  io::Result<void> estimate();
  io::Result<void> checkInputs() const;
  void report();

  const BuildPlan& plan_;
  TileDatabase& database_;
  const ProgressSink& progress_;
  std::stop_token stop_;
  BuildCut cut_;
  InputSet inputs_;
  MemoryBudget budget_;
  raster::BlockCacheLimit blockCache_;
  std::optional<TileDatabase> baseRows_;
  std::optional<BaseLayer> base_;

  BuildPosition position_;  ///< of what is in the open group
  BuildPosition committed_;
  std::uint64_t groupSize_ = 0;  ///< candidates
  std::set<int> groupInputs_;    ///< that may have been read for the open group
  bool groupIsOpen_ = false;
  std::uint64_t total_ = 0;
  std::uint64_t doneBefore_ = 0;
  std::chrono::steady_clock::time_point lastReport_;

  std::deque<Candidate> pending_;
  std::mutex makersMutex_;
  std::map<std::thread::id, std::unique_ptr<TileMaker>> makers_;
  OrderedWork<Made> work_;  // last: its threads use the makers
};

}  // namespace tellurion::pyramid
