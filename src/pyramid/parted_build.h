#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "pyramid/pyramid_builder.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

struct PreparedBuild;

/// A build cut into parts that may be made in any order, by any processes, on any machines; joined, they are the same
/// bytes as one process's build. A part is a subtree of the tiling; which there are depends on the inputs and options
/// alone. What a part makes are the pieces of the build's first level in its subtree: all of the deepest levels, or the
/// deepest level alone where finer elevation moves coarser. One thread only.
class PartedBuild {
 public:
  /// Opens the inputs and decides. An append is not cut.
  static io::Result<PartedBuild> plan(const BuildOptions& options, std::stop_token stop = {});

  const std::vector<tiling::TileId>& parts() const { return parts_; }
  /// Where the parts are: OUTPUT.parts.
  std::filesystem::path folder() const;
  /// OUTPUT.parts/00001.tdb, of a part by its index.
  std::filesystem::path shard(std::size_t part) const;

  /// Makes a part; goes on with what a process left of it; nothing is done where it is finished. One process at a time.
  /// The folder must be there. Returns what the inputs have warned of while they were sampled.
  io::Result<std::vector<std::string>> make(std::size_t part, std::stop_token stop = {}) const;

  /// Joins the finished parts to the output and makes the coarser levels; goes on where it was stopped or killed.
  io::Result<BuildReport> join(std::span<const std::filesystem::path> shards, const ProgressSink& progress = {},
                               std::stop_token stop = {}) const;

  /// Of the output, where it is there, built from the same inputs with the same options.
  io::Result<std::optional<BuildReport>> finished() const;

 private:
  PartedBuild(BuildOptions options, std::shared_ptr<const PreparedBuild> prepared);
  BuildOptions options_;
  std::shared_ptr<const PreparedBuild> prepared_;
  std::vector<tiling::TileId> parts_;
};

/// What the shards were made for, joined to `output`. The inputs must be where they were, by the same names.
struct MergeOptions {
  std::filesystem::path output;
  std::vector<std::filesystem::path> shards;  ///< all of one build, in any order
  std::uint64_t memoryBytes = std::uint64_t{1} << 30u;
  int jobs = 0;  ///< worker threads; 0: one for each core
};
io::Result<BuildReport> mergeShards(const MergeOptions& options, const ProgressSink& progress = {},
                                    std::stop_token stop = {});

/// Sentences for the user, and how many parts are made of how many.
struct PartsSink {
  std::function<void(const std::string&)> tell;
  std::function<void(std::size_t made, std::size_t parts)> progress;
};

/// Makes every count-th part, the first being `index` (from 0), and joins nothing.
io::Result<void> buildShare(const BuildOptions& options, std::size_t index, std::size_t count, const PartsSink& sink,
                            std::stop_token stop = {});

/// Builds together with all processes that call this with the same options, on this machine or on others that see the
/// same files: each takes parts that nobody has, and one joins them. A part whose process ended, however, is taken by
/// another one. Returns when the output is there.
io::Result<BuildReport> buildTogether(const BuildOptions& options, const PartsSink& sink,
                                      const ProgressSink& joining = {}, std::stop_token stop = {});

}  // namespace tellurion::pyramid
