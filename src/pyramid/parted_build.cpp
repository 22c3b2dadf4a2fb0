#include "pyramid/parted_build.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "pyramid/build_output.h"
#include "pyramid/build_run.h"
#include "pyramid/imagery_cleaning.h"
#include "pyramid/shard.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::size_t kFewParts = 64;  // enough to keep some dozen processes busy to the end
constexpr int kMostLevels = 5;         // a part has no more than 4^5 pieces: a minute or so
constexpr std::size_t kFilesOfWalk = 256;

io::Result<std::vector<tiling::TileId>> subtreesAt(const BuildPlan& plan, InputSet& inputs, int level) {
  TileWalk walk(plan, inputs, nullptr, plan.startLevel(), 0, {.within = {}, .stopAt = level});
  std::vector<tiling::TileId> subtrees;
  while (true) {
    const auto candidate = walk.next();
    if (!candidate) return tl::unexpected(candidate.error());
    if (!*candidate) return subtrees;
    subtrees.push_back((*candidate)->id);
  }
}

/// The coarsest cut that gives more than few parts, none of which is large.
io::Result<std::vector<tiling::TileId>> cutOf(const BuildPlan& plan) {
  InputSet inputs(plan, kFilesOfWalk, 0);
  for (int level = std::max(0, plan.startLevel() - kMostLevels);; ++level) {
    auto subtrees = subtreesAt(plan, inputs, level);
    if (!subtrees || subtrees->size() >= kFewParts || level == plan.startLevel()) return subtrees;
  }
}

using Warnings = std::vector<std::string>;

io::Result<Warnings> runPart(const BuildOptions& options, const BuildPlan& plan, const tiling::TileId& part,
                             const fs::path& path, std::stop_token stop) {
  auto opened = openPart(path, plan, {});
  if (!opened) return tl::unexpected(opened.error());
  TileDatabase& database = opened->database;
  if (auto ok = makeShard(database, options, part); !ok) return tl::unexpected(ok.error());
  const auto position = database.position();
  if (!position) return tl::unexpected(position.error());
  if (!*position) return Warnings{};  // killed before it was renamed
  const int jobs = jobsFor(options);
  const std::uint64_t held = std::min(plan.bytesHeld(jobs), options.memoryBytes);
  const BuildRun::Resources resources{.jobs = jobs, .memoryBytes = options.memoryBytes - held};
  const ProgressSink untold;
  BuildRun run(plan, database, resources, untold, std::move(stop), {.part = part, .shards = nullptr});
  if (auto ok = run.run(**position); !ok) return tl::unexpected(ok.error());
  if (auto ok = database.begin(); !ok) return tl::unexpected(ok.error());
  auto ok = database.writePosition(std::nullopt);
  if (ok) ok = finishShard(database);
  if (ok) ok = database.commit();
  if (!ok) {
    database.rollback();
    return tl::unexpected(ok.error());
  }
  const std::set<std::string> warnings = run.warnings();
  return Warnings(warnings.begin(), warnings.end());
}

}  // namespace

PartedBuild::PartedBuild(BuildOptions options, std::shared_ptr<const PreparedBuild> prepared)
    : options_(std::move(options)), prepared_(std::move(prepared)) {}

io::Result<PartedBuild> PartedBuild::plan(const BuildOptions& options, std::stop_token stop) {
  if (options.append) {
    return io::fail(Code::invalidArgument,
                    "an append is one process's work: leave --part and --share out, and start it without mpirun");
  }
  auto prepared = prepareBuild(options, std::move(stop));
  if (!prepared) return tl::unexpected(prepared.error());
  auto parts = cutOf(prepared->plan);
  if (!parts) return tl::unexpected(parts.error());
  PartedBuild build(options, std::make_shared<const PreparedBuild>(std::move(*prepared)));
  build.parts_ = std::move(*parts);
  return build;
}

fs::path PartedBuild::folder() const {
  return withSuffix(options_.output, ".parts");
}

fs::path PartedBuild::shard(std::size_t part) const {
  return folder() / fmt::format("{:05}.tdb", part + 1);
}

io::Result<std::vector<std::string>> PartedBuild::make(std::size_t part, std::stop_token stop) const {
  const fs::path path = shard(part);
  std::error_code error;
  if (fs::exists(path, error)) {
    const auto finished = TileDatabase::open(path, io::SqliteConnection::Mode::read);
    if (!finished) return tl::unexpected(finished.error());
    if (finished->meta().buildKey == prepared_->plan.meta.buildKey) return Warnings{};
    return io::fail(Code::invalidArgument,
                    fmt::format("is a part of another build, of other inputs or options; remove {} to start over",
                                folder().string()),
                    path.string());
  }
  const fs::path unfinished = withSuffix(path, ".part");
  auto warnings = runPart(options_, prepared_->plan, parts_[part], unfinished, std::move(stop));
  if (!warnings) return tl::unexpected(afterFailure(warnings.error(), options_, prepared_->plan, unfinished));
  if (auto ok = moved(unfinished, path); !ok) return tl::unexpected(ok.error());
  return warnings;
}

io::Result<BuildReport> PartedBuild::join(std::span<const fs::path> shards, const ProgressSink& progress,
                                          std::stop_token stop) const {
  if (prepared_->isFinished) return makeOutput(options_, *prepared_, nullptr, progress, std::move(stop));
  auto set = ShardSet::open(shards, prepared_->plan, parts_);
  if (!set) return tl::unexpected(set.error());
  return makeOutput(options_, *prepared_, &*set, progress, std::move(stop));
}

io::Result<std::optional<BuildReport>> PartedBuild::finished() const {
  const auto existing = finishedAt(options_.output);
  if (!existing) return tl::unexpected(existing.error());
  if (!*existing || (*existing)->requestKey != prepared_->plan.meta.requestKey) return std::optional<BuildReport>();
  auto report = reportOn(options_.output);
  if (!report) return tl::unexpected(report.error());
  report->alreadyComplete = true;
  return std::optional(std::move(*report));
}

io::Result<BuildReport> mergeShards(const MergeOptions& merge, const ProgressSink& progress, std::stop_token stop) {
  if (merge.shards.empty()) return io::fail(Code::invalidArgument, "no part to join: name all of a build");
  auto request = requestOf(merge.shards.front());
  if (!request) return tl::unexpected(request.error());
  BuildOptions& options = request->options;
  options.output = merge.output;
  options.memoryBytes = merge.memoryBytes;
  options.jobs = merge.jobs;
  const auto build = PartedBuild::plan(options, stop);
  if (!build) {
    io::Failure failure = build.error();
    std::error_code error;
    if (failure.code == Code::notFound && fs::current_path(error).string() != request->folder) {
      failure.message += fmt::format("; the parts were made in {}, start the merge there", request->folder);
    }
    return tl::unexpected(failure);
  }
  return build->join(merge.shards, progress, std::move(stop));
}

}  // namespace tellurion::pyramid
