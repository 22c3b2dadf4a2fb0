#include "pyramid/build_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "pyramid/database_file.h"

namespace tellurion::pyramid {

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

io::Result<std::optional<DatabaseMeta>> finishedAt(const fs::path& output) {
  std::error_code error;
  if (!fs::exists(output, error)) return std::optional<DatabaseMeta>{};
  const auto database = TileDatabase::open(output, io::SqliteConnection::Mode::read);
  if (!database) return tl::unexpected(database.error());
  if (!database->meta().complete) return tl::unexpected(unfinished(*database));
  return std::optional(database->meta());
}

namespace {

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

/// Whether the file that was left is this build's, or a copy of what it extends.
io::Result<void> checkLeft(const TileDatabase& database, const BuildPlan& plan, const std::string& baseKey) {
  const std::string& key = database.meta().buildKey;
  if (key == plan.meta.buildKey || (plan.base && key == baseKey)) return {};
  if (std::ranges::find(plan.olderKeys, key) != plan.olderKeys.end()) {
    return io::fail(Code::invalidArgument,
                    "was begun by an older version of this program, which stored it otherwise, and cannot be gone on "
                    "with; remove the file to start over",
                    database.connection().path());
  }
  return io::fail(
      Code::invalidArgument,
      fmt::format(
          "is left from a build with other inputs or options; finish that one ('{}', with {} as they were given "
          "then), or remove the file to start over",
          commandToGoOn(database), optionsToRepeat(database.meta())),
      database.connection().path());
}

io::Result<OpenedOutput> openExisting(const fs::path& part, const BuildPlan& plan, const std::string& baseKey,
                                      const BuildPosition& start) {
  auto database = TileDatabase::open(part, io::SqliteConnection::Mode::write);
  if (!database) return tl::unexpected(database.error());
  if (auto ok = checkLeft(*database, plan, baseKey); !ok) return tl::unexpected(ok.error());
  if (plan.base && database->meta().buildKey == baseKey) {
    if (auto ok = startAppend(*database, plan, start); !ok) return tl::unexpected(ok.error());
    return OpenedOutput{std::move(*database), false};
  }
  return OpenedOutput{std::move(*database), true};
}

/// Whether an input, or a file that it is read from, is why a build ended.
bool isOfAnInput(const io::Failure& failure, const BuildPlan& plan) {
  return std::ranges::any_of(plan.inputs, [&](const PlannedInput& input) {
    return input.path == failure.where ||
           std::ranges::any_of(input.files, [&](const FileStamp& file) { return file.path == failure.where; });
  });
}

/// Whether nothing but a beginning is in the file: no tile of this build was committed.
bool isMerelyBegun(const fs::path& part) {
  const auto database = TileDatabase::open(part, io::SqliteConnection::Mode::read);
  if (!database) return false;
  const auto position = database->position();
  return position && *position && (*position)->done == 0;
}

}  // namespace

io::Result<OpenedOutput> openPart(const fs::path& part, const BuildPlan& plan, const std::string& baseKey) {
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
  return OpenedOutput{std::move(*created), false};
}

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

int jobsFor(const BuildOptions& options) {
  if (options.jobs > 0) return options.jobs;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

io::Failure afterFailure(io::Failure failure, const BuildOptions& options, const BuildPlan& plan,
                         const fs::path& part) {
  const bool isBelow = plan.base && failure.where == plan.base->string();
  if (!isBelow && !isOfAnInput(failure, plan)) return failure;
  if (!isMerelyBegun(part)) {
    failure.message += fmt::format(
        "; what is built is kept: with the file as it was (its time of change too), the same command goes on; to start "
        "over with another, remove {}",
        part.string());
    return failure;
  }
  std::error_code error;
  fs::remove(part, error);
  failure.message += options.append ? fmt::format("; nothing was appended, {} is as it was", options.output.string())
                                    : "; nothing was built";
  return failure;
}

}  // namespace tellurion::pyramid
