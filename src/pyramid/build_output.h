#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pyramid/build_plan.h"

namespace tellurion::pyramid {

/// The files of a build: what is finished, what is worked on, and what becomes of it when the work fails.

std::filesystem::path withSuffix(const std::filesystem::path& path, const char* suffix);
io::Result<void> moved(const std::filesystem::path& from, const std::filesystem::path& to);
io::Result<BuildReport> reportOn(const std::filesystem::path& path);

/// What the finished database at the output says; nothing where there is none.
io::Result<std::optional<DatabaseMeta>> finishedAt(const std::filesystem::path& output);

struct OpenedOutput {
  TileDatabase database;
  bool resumed = false;
};

/// The file that is worked on: an interrupted run's, or a new one. baseKey: of the database that an append extends.
io::Result<OpenedOutput> openPart(const std::filesystem::path& part, const BuildPlan& plan, const std::string& baseKey);
/// What openPart would refuse, told before the work that comes first.
io::Result<void> checkPart(const std::filesystem::path& part, const BuildPlan& plan, const std::string& baseKey);

int jobsFor(const BuildOptions& options);

/// What is done is kept whatever the failure, and told; a mere beginning that an input ended is not left in the way of
/// the next build of that name.
io::Failure afterFailure(io::Failure failure, const BuildOptions& options, const BuildPlan& plan,
                         const std::filesystem::path& part);

/// What is decided before a build's first tile.
struct PreparedBuild {
  BuildPlan plan;
  std::string baseKey;
  bool isFinished = false;  ///< the same build had been finished before
};
io::Result<PreparedBuild> prepareBuild(const BuildOptions& options, std::stop_token stop);

/// Makes the output; the first level's pieces out of shards where there are some.
class ShardSet;
io::Result<BuildReport> makeOutput(const BuildOptions& options, const PreparedBuild& prepared, ShardSet* shards,
                                   const ProgressSink& progress, std::stop_token stop);

}  // namespace tellurion::pyramid
