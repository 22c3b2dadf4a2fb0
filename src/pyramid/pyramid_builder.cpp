#include "pyramid/pyramid_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <thread>

#include "pyramid/build_output.h"
#include "pyramid/build_run.h"
#include "pyramid/database_file.h"
#include "pyramid/imagery_cleaning.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

/// The last commit: what only the end knows. There must be a tile.
io::Result<void> complete(TileDatabase& database, const tiling::TileId& deepest) {
  DatabaseMeta meta = database.meta();
  meta.maxLevel = deepest.level;
  meta.complete = true;
  if (auto ok = database.begin(); !ok) return ok;
  auto ok = database.writeMeta(meta);
  if (ok) ok = database.writePosition(std::nullopt);
  if (ok) ok = database.commit();
  if (!ok) database.rollback();
  return ok;
}

constexpr std::size_t kMostWarnings = 100;

std::vector<std::string> bounded(const std::set<std::string>& warnings) {
  std::vector<std::string> told(
      warnings.begin(),
      std::next(warnings.begin(), static_cast<std::ptrdiff_t>(std::min(warnings.size(), kMostWarnings))));
  if (warnings.size() > told.size()) told.push_back(fmt::format("and {} warnings more", warnings.size() - told.size()));
  return told;
}

/// False: the inputs turned out to hold no data at all, and so does the file.
io::Result<bool> runToTheEnd(const BuildOptions& options, const BuildPlan& plan, TileDatabase& database,
                             ShardSet* shards, const ProgressSink& progress, std::stop_token stop,
                             std::set<std::string>& warnings) {
  if (database.meta().complete) return true;
  const auto position = database.position();
  if (!position) return tl::unexpected(position.error());
  if (!*position) return io::fail(Code::corrupt, "does not say where it was; remove it", database.connection().path());
  const int jobs = jobsFor(options);
  const std::uint64_t held = std::min(plan.bytesHeld(jobs), options.memoryBytes);
  const BuildRun::Resources resources{.jobs = jobs, .memoryBytes = options.memoryBytes - held};
  BuildRun run(plan, database, resources, progress, std::move(stop), {.part = {}, .shards = shards});
  if (auto ok = run.run(**position); !ok) return tl::unexpected(ok.error());
  warnings.merge(run.warnings());
  const auto lastRow = database.connection().integer("SELECT max(id) FROM tiles");
  if (!lastRow) return tl::unexpected(lastRow.error());
  const auto deepest = tileOfRowNumber(*lastRow);
  if (!deepest) return false;
  if (auto ok = complete(database, *deepest); !ok) return tl::unexpected(ok.error());
  return true;
}

}  // namespace

io::Result<std::string> keyOfBuild(const BuildOptions& options) {
  auto plan = planBuild(options, std::nullopt);
  if (!plan) return tl::unexpected(std::move(plan.error()));
  return std::move(plan->meta.buildKey);
}

io::Result<PreparedBuild> prepareBuild(const BuildOptions& options, std::stop_token stop) {
  if (auto ok = checkOutputName(options.output); !ok) return tl::unexpected(ok.error());
  const auto existing = finishedAt(options.output);
  if (!existing && existing.error().code == Code::invalidArgument) return tl::unexpected(existing.error());
  if (!existing) {
    io::Failure failure = existing.error();
    failure.message += "; it is in the way of the build: remove it or choose another name";
    return tl::unexpected(failure);
  }
  if (options.append && !*existing) {
    return io::fail(Code::notFound, "nothing to append to; leave --append out to build it", options.output.string());
  }
  auto plan = planBuild(options, options.append ? *existing : std::nullopt);
  if (!plan) return tl::unexpected(plan.error());
  if (*existing && (*existing)->requestKey == plan->meta.requestKey) {
    return PreparedBuild{.plan = std::move(*plan), .baseKey = {}, .isFinished = true};
  }
  if (*existing && !options.append) {
    return io::fail(
        Code::invalidArgument,
        "is there already, built from other inputs or with other options; remove it, choose another name, or "
        "lay the inputs over it with --append",
        options.output.string());
  }
  const std::string baseKey = options.append ? (*existing)->buildKey : std::string();
  if (auto ok = checkPart(withSuffix(options.output, ".part"), *plan, baseKey); !ok) return tl::unexpected(ok.error());
  auto cleaned = ImageryCleaning::prepare(*plan, options.memoryBytes, stop);
  if (!cleaned) return tl::unexpected(cleaned.error());
  plan->cleaned = std::move(*cleaned);
  if (plan->cleaned) {
    const std::vector<std::string>& warnings = plan->cleaned->warnings();
    plan->warnings.insert(plan->warnings.end(), warnings.begin(), warnings.end());
  }
  return PreparedBuild{.plan = std::move(*plan), .baseKey = baseKey, .isFinished = false};
}

io::Result<BuildReport> makeOutput(const BuildOptions& options, const PreparedBuild& prepared, ShardSet* shards,
                                   const ProgressSink& progress, std::stop_token stop) {
  const BuildPlan& plan = prepared.plan;
  if (prepared.isFinished) {
    auto report = reportOn(options.output);
    if (report) report->alreadyComplete = true;
    return report;
  }
  const fs::path part = withSuffix(options.output, ".part");
  bool resumed = false;
  io::Result<bool> hasData = false;
  std::set<std::string> warnings(plan.warnings.begin(), plan.warnings.end());
  {  // the database is closed before it is renamed or removed
    auto opened = openPart(part, plan, prepared.baseKey);
    if (!opened) return tl::unexpected(opened.error());
    resumed = opened->resumed;
    hasData = runToTheEnd(options, plan, opened->database, shards, progress, std::move(stop), warnings);
  }
  if (!hasData) return tl::unexpected(afterFailure(hasData.error(), options, plan, part));
  if (!*hasData) {
    std::error_code error;
    fs::remove(part, error);
    return io::fail(Code::invalidArgument, "no input has any data: nothing to build", options.inputs.back());
  }
  if (auto ok = moved(part, options.output); !ok) return tl::unexpected(ok.error());
  auto report = reportOn(options.output);
  if (report) {
    report->resumed = resumed;
    report->warnings = bounded(warnings);
  }
  return report;
}

io::Result<BuildReport> buildPyramid(const BuildOptions& options, const ProgressSink& progress, std::stop_token stop) {
  const auto prepared = prepareBuild(options, stop);
  if (!prepared) return tl::unexpected(prepared.error());
  return makeOutput(options, *prepared, nullptr, progress, std::move(stop));
}

}  // namespace tellurion::pyramid
