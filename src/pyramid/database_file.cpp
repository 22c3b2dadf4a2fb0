#include "pyramid/database_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "pyramid/fill_plan.h"
#include "pyramid/shard.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::string_view kPart = ".part";
constexpr std::size_t kMostInputsNamed = 12;

std::string shellWord(const std::string& word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word)
    out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// How many of the sources are those of the finished database that the build extends; 0 where there is none.
std::size_t sourcesBelow(const fs::path& output) {
  std::error_code error;
  if (!fs::exists(output, error)) return 0;
  const auto below = TileDatabase::open(output, io::SqliteConnection::Mode::read);
  return below ? below->meta().sources.size() : 0;
}

std::string inputsNamed(const std::vector<std::string>& sources, std::size_t first) {
  std::string words;
  for (std::size_t i = first; i < sources.size() && i - first < kMostInputsNamed; ++i)
    words += " " + shellWord(sources[i]);
  if (sources.size() > first + kMostInputsNamed) words += fmt::format(" ... ({} inputs)", sources.size() - first);
  return words;
}

std::string bodyNamed(const geo::Body& body) {
  const auto known = geo::bodyByName(body.name);
  return known && *known == body ? " --body " + body.name : " --body FILE";
}

/// Of a build without --append, where it is not what is done without the option.
std::string fillNamed(const DatabaseMeta& meta) {
  if (meta.kind != raster::Kind::elevation || meta.fillVoids_m == kFillWithoutLimit_m) return {};
  return fmt::format(" --fill-voids {}", meta.fillVoids_m);
}

std::string maxErrorNamed(const DatabaseMeta& meta) {
  return meta.maxError_m > 0.0 ? fmt::format(" --max-error {}", meta.maxError_m) : std::string();
}

}  // namespace

io::Result<void> checkDatabaseFile(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_regular_file(status)) return {};
  const std::string where = path.string();
  if (fs::is_directory(status)) return io::fail(Code::invalidArgument, "is a folder, not a tile database", where);
  if (fs::exists(status)) return io::fail(Code::invalidArgument, "is not a file", where);
  const fs::path part = where + std::string(kPart);
  if (fs::exists(part, error)) {
    return io::fail(
        Code::notFound,
        fmt::format("is not finished: the build is in {0}; 'tellurion info {0}' says how to go on", part.string()),
        where);
  }
  return io::fail(Code::notFound, "there is no such file", where);
}

io::Result<void> checkOutputName(const fs::path& path) {
  std::error_code error;
  const std::string where = path.string();
  if (path.empty()) return io::fail(Code::invalidArgument, "the database to write has no name");
  if (fs::is_directory(path, error) || path.filename().empty()) {
    return io::fail(Code::invalidArgument,
                    fmt::format("is a folder; name the file to write, as {}", (path / "name.tdb").string()), where);
  }
  const fs::path folder = path.parent_path();
  if (folder.empty() || fs::is_directory(folder, error)) return {};
  if (fs::exists(folder, error))
    return io::fail(Code::invalidArgument, fmt::format("{} is a file, not a folder", folder.string()), where);
  return io::fail(Code::notFound,
                  fmt::format("the folder {0} does not exist; make it first: mkdir -p {0}", folder.string()), where);
}

bool isTileDatabaseFile(const fs::path& path) {
  constexpr std::string_view kSqlite("SQLite format 3\0", 16);
  constexpr std::string_view kTellurion = "TLRN";
  constexpr std::size_t kApplicationIdAt = 68;
  std::array<char, kApplicationIdAt + kTellurion.size()> head{};
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::ifstream file(path, std::ios::binary);
  if (!file.read(head.data(), head.size())) return false;
  const std::string_view bytes(head.data(), head.size());
  return bytes.starts_with(kSqlite) && bytes.substr(kApplicationIdAt) == kTellurion;
}

std::string commandToGoOn(const TileDatabase& part) {
  const DatabaseMeta& meta = part.meta();
  std::string output = part.connection().path();
  if (output.ends_with(kPart)) output.resize(output.size() - kPart.size());
  const std::size_t below = sourcesBelow(output);
  const bool appends = below > 0 && below < meta.sources.size();
  return fmt::format("tellurion build {}{} --kind {} --tiling {}{}{}", shellWord(output),
                     inputsNamed(meta.sources, appends ? below : 0), raster::nameOf(meta.kind),
                     tiling::nameOf(meta.scheme), bodyNamed(meta.body),
                     appends ? " --append" : fillNamed(meta) + maxErrorNamed(meta));
}

std::string_view optionsToRepeat(const DatabaseMeta& meta) {
  return meta.kind == raster::Kind::elevation
             ? "--max-level, --nodata, --region and --vertical-datum"
             : "--max-level, --nodata, --region, --format, --match-colours, --feather, --cut and --clouds";
}

io::Failure unfinished(const TileDatabase& database) {
  const std::string& path = database.connection().path();
  if (isShard(database)) {
    return {.code = Code::invalidArgument,
            .message =
                "is a part of a build ('build --part' or '--share'): 'tellurion merge OUT.tdb' with all its "
                "parts joins them",
            .where = path};
  }
  if (!path.ends_with(kPart)) {
    return {
        .code = Code::invalidArgument,
        .message = fmt::format("is not finished: a build works in OUT.tdb.part, and this file was renamed; rename it "
                               "back to {}.part, then '{}', with {} as they were given then, goes on with it",
                               path, commandToGoOn(database), optionsToRepeat(database.meta())),
        .where = path};
  }
  const auto tiles = database.connection().integer("SELECT count(*) FROM tiles");
  return {.code = Code::invalidArgument,
          .message = fmt::format("is an unfinished build, {} tiles so far; '{}', with {} as they were given then, goes "
                                 "on with it",
                                 tiles ? *tiles : 0, commandToGoOn(database), optionsToRepeat(database.meta())),
          .where = path};
}

}  // namespace tellurion::pyramid
