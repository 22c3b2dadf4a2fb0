#include "pyramid/pyramid_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>
#include <thread>

#include "pyramid/build_run.h"
#include "pyramid/database_file.h"
#include "pyramid/imagery_cleaning.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

fs::path withSuffix(const fs::path& path, const char* suffix) {
  fs::path result = path;
  result += suffix;
  return result;
}

io::Result<void> moved(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) return io::fail(Code::ioError, "cannot be renamed: " + error.message(), from.string());
  return {};
}

io::Result<BuildReport> reportOn(const fs::path& path) {
  const auto database = TileDatabase::open(path, io::SqliteConnection::Mode::read);
  if (!database) return tl::unexpected(database.error());
  const auto tiles = database->connection().integer("SELECT count(*) FROM tiles");
  if (!tiles) return tl::unexpected(tiles.error());
  std::error_code error;
  BuildReport report;
  report.tiles = static_cast<std::uint64_t>(*tiles);
  report.bytes = fs::file_size(path, error);
  report.maxLevel = database->meta().maxLevel;
  return report;
}

/// What the finished database at the output says; nothing where there is none.
io::Result<std::optional<DatabaseMeta>> finishedAt(const fs::path& output) {
  std::error_code error;
  if (!fs::exists(output, error)) return std::optional<DatabaseMeta>{};
  const auto database = TileDatabase::open(output, io::SqliteConnection::Mode::read);
  if (!database) return tl::unexpected(database.error());
  if (!database->meta().complete) return tl::unexpected(unfinished(*database));
  return std::optional(database->meta());
}

/// A copy of the database that is extended, made so that a kill leaves either a whole copy or none.
io::Result<void> copyBase(const fs::path& base, const fs::path& part) {
  const fs::path half = withSuffix(part, ".copy");
  std::error_code error;
  fs::copy_file(base, half, fs::copy_options::overwrite_existing, error);
  if (!error) return moved(half, part);
  const std::string why = error.message();
  fs::remove(half, error);
  return io::fail(Code::ioError, "cannot be copied: " + why, base.string());
}

/// The first commit of an append: from here on the copy is this build's.
io::Result<void> startAppend(TileDatabase& database, const BuildPlan& plan, const BuildPosition& start) {
  if (auto ok = database.begin(); !ok) return ok;
  auto ok = database.writeMeta(plan.meta);
  if (ok) ok = database.writePosition(start);
  if (ok) ok = database.commit();
  if (!ok) database.rollback();
  return ok;
}

struct Opened {
  TileDatabase database;
  bool resumed = false;
};

/// Whether the file that was left is this build's, or a copy of what it extends.
io::Result<void> checkLeft(const TileDatabase& database, const BuildPlan& plan, const std::string& baseKey) {
  const std::string& key = database.meta().buildKey;
  if (key == plan.meta.buildKey || (plan.base && key == baseKey)) return {};
  return io::fail(
      Code::invalidArgument,
      fmt::format(
          "is left from a build with other inputs or options; finish that one ('{}', with {} as they were given "
          "then), or remove the file to start over",
          commandToGoOn(database), optionsToRepeat(database.meta())),
      database.connection().path());
}

io::Result<Opened> openExisting(const fs::path& part, const BuildPlan& plan, const std::string& baseKey,
                                const BuildPosition& start) {
  auto database = TileDatabase::open(part, io::SqliteConnection::Mode::write);
  if (!database) return tl::unexpected(database.error());
  if (auto ok = checkLeft(*database, plan, baseKey); !ok) return tl::unexpected(ok.error());
  if (plan.base && database->meta().buildKey == baseKey) {
    if (auto ok = startAppend(*database, plan, start); !ok) return tl::unexpected(ok.error());
    return Opened{std::move(*database), false};
  }
  return Opened{std::move(*database), true};
}

/// The file that is worked on: an interrupted run's, or a new one.
io::Result<Opened> openPart(const fs::path& part, const BuildPlan& plan, const std::string& baseKey) {
  const BuildPosition start{.level = plan.startLevel(), .row = 0, .done = 0};
  std::error_code error;
  if (fs::exists(part, error)) {
    const auto blank = TileDatabase::isBlank(part);
    if (!blank) return tl::unexpected(blank.error());
    if (!*blank) return openExisting(part, plan, baseKey, start);
  }
  if (plan.base) {
    if (auto ok = copyBase(*plan.base, part); !ok) return tl::unexpected(ok.error());
    return openExisting(part, plan, baseKey, start);
  }
  auto created = TileDatabase::create(part, plan.meta, start);
  if (!created) return tl::unexpected(created.error());
  return Opened{std::move(*created), false};
}

/// What openPart would refuse, told before the work that comes first.
io::Result<void> checkPart(const fs::path& part, const BuildPlan& plan, const std::string& baseKey) {
  std::error_code error;
  if (!fs::exists(part, error)) return {};
  const auto blank = TileDatabase::isBlank(part);
  if (!blank) return tl::unexpected(blank.error());
  if (*blank) return {};
  const auto database = TileDatabase::open(part, io::SqliteConnection::Mode::write);
  if (!database) return tl::unexpected(database.error());
  return checkLeft(*database, plan, baseKey);
}

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

int jobsFor(const BuildOptions& options) {
  if (options.jobs > 0) return options.jobs;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
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
                             const ProgressSink& progress, std::stop_token stop, std::set<std::string>& warnings) {
  if (database.meta().complete) return true;
  const auto position = database.position();
  if (!position) return tl::unexpected(position.error());
  if (!*position) return io::fail(Code::corrupt, "does not say where it was; remove it", database.connection().path());
  const std::uint64_t maps = plan.cleaned ? plan.cleaned->bytes() : 0;
  const BuildRun::Resources resources{.jobs = jobsFor(options), .memoryBytes = options.memoryBytes - maps};
  BuildRun run(plan, database, resources, progress, std::move(stop));
  if (auto ok = run.run(**position); !ok) return tl::unexpected(ok.error());
  warnings.merge(run.warnings());
  const auto lastRow = database.connection().integer("SELECT max(id) FROM tiles");
  if (!lastRow) return tl::unexpected(lastRow.error());
  const auto deepest = tileOfRowNumber(*lastRow);
  if (!deepest) return false;
  if (auto ok = complete(database, *deepest); !ok) return tl::unexpected(ok.error());
  return true;
}

/// Whether the same command would fail again: an input that is there but cannot be read, or one that is no longer what
/// was planned with; of an append also the database below, or the copy of it. An input that is out of reach (a share
/// that went away) may come back, and what is done is kept for it.
bool wouldFailAgain(const io::Failure& failure, const BuildPlan& plan, const fs::path& part) {
  const auto input = std::ranges::find(plan.inputs, failure.where, &PlannedInput::path);
  if (input != plan.inputs.end()) {
    std::error_code error;
    if (!fs::exists(input->path, error)) return false;
    return failure.code == Code::corrupt || failure.code == Code::invalidArgument ||
           signatureOf(*input) != input->signature;
  }
  const bool isBelow = plan.base && (failure.where == plan.base->string() || failure.where == part.string());
  return failure.code == Code::corrupt && isBelow;
}

/// A build that cannot be finished is not left in the way of the next one of that name.
io::Failure afterFailure(io::Failure failure, const BuildOptions& options, const BuildPlan& plan,
                         const fs::path& part) {
  if (!wouldFailAgain(failure, plan, part)) return failure;
  std::error_code error;
  fs::remove(part, error);
  failure.message += options.append ? fmt::format("; nothing was appended, {} is as it was", options.output.string())
                                    : "; nothing was built";
  return failure;
}

io::Result<BuildReport> build(const BuildOptions& options, const BuildPlan& plan, const std::string& baseKey,
                              const ProgressSink& progress, std::stop_token stop) {
  const fs::path part = withSuffix(options.output, ".part");
  bool resumed = false;
  io::Result<bool> hasData = false;
  std::set<std::string> warnings(plan.warnings.begin(), plan.warnings.end());
  {  // the database is closed before it is renamed or removed
    auto opened = openPart(part, plan, baseKey);
    if (!opened) return tl::unexpected(opened.error());
    resumed = opened->resumed;
    hasData = runToTheEnd(options, plan, opened->database, progress, std::move(stop), warnings);
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

}  // namespace

io::Result<std::string> keyOfBuild(const BuildOptions& options) {
  auto plan = planBuild(options, std::nullopt);
  if (!plan) return tl::unexpected(std::move(plan.error()));
  return std::move(plan->meta.buildKey);
}

io::Result<BuildReport> buildPyramid(const BuildOptions& options, const ProgressSink& progress, std::stop_token stop) {
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
    auto report = reportOn(options.output);
    if (report) report->alreadyComplete = true;
    return report;
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
  return build(options, *plan, baseKey, progress, std::move(stop));
}

}  // namespace tellurion::pyramid
