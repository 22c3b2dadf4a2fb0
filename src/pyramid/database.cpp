#include "pyramid/database.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <map>

#include "raster/codec.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

constexpr std::int64_t kApplicationId = 0x544C524E;  // "TLRN"

constexpr std::string_view kTilesTable =
    "CREATE TABLE tiles (id INTEGER PRIMARY KEY, level INTEGER NOT NULL, root INTEGER NOT NULL, x INTEGER NOT NULL, "
    "y INTEGER NOT NULL, min_m REAL, max_m REAL, error_m REAL, child_mask INTEGER NOT NULL, children BLOB, "
    "checksum INTEGER NOT NULL, payload BLOB NOT NULL)";
constexpr std::string_view kMetaTable = "CREATE TABLE meta (key TEXT PRIMARY KEY, value) WITHOUT ROWID";
constexpr std::string_view kSourcesTable = "CREATE TABLE sources (number INTEGER PRIMARY KEY, path TEXT NOT NULL)";
constexpr std::string_view kFillsTable = "CREATE TABLE fills (id INTEGER PRIMARY KEY, depths BLOB NOT NULL)";
constexpr double kDepthStep = 1.0;

/// Only what is filled has the table.
bool hasFills(const DatabaseMeta& meta) {
  return meta.fillVoids_m > 0.0;
}

io::Result<void> checkSchema(const io::SqliteConnection& connection) {
  const auto application = connection.integer("PRAGMA application_id");
  if (!application) return tl::unexpected(application.error());
  if (*application != kApplicationId) {
    return io::fail(Code::corrupt, "an SQLite file, but not a tile database", connection.path());
  }
  const auto version = connection.integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*version < 1 || *version > kNewestFormatVersion) {
    return io::fail(
        Code::unsupported,
        fmt::format("tile database of format version {}; this program reads versions 1 to {}: build it again", *version,
                    kNewestFormatVersion),
        connection.path());
  }
  for (const std::string_view table : {kTilesTable, kMetaTable, kSourcesTable}) {
    auto found = connection.prepare("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND sql = ?");
    if (!found) return tl::unexpected(found.error());
    found->bind(1, table);
    const auto row = found->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row || found->integer(0) != 1) {
      return io::fail(Code::corrupt, "its tables are not those of a tile database", connection.path());
    }
  }
  return {};
}

io::Result<void> checkVersion(const io::SqliteConnection& connection, tiling::Scheme scheme) {
  const auto version = connection.integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*version == formatVersionOf(scheme)) return {};
  return io::fail(Code::unsupported,
                  fmt::format("tile database of the {} tiling in format version {}; this program reads version {} of "
                              "it: build it again",
                              tiling::nameOf(scheme), *version, formatVersionOf(scheme)),
                  connection.path());
}

io::Result<void> createTables(const io::SqliteConnection& connection, const DatabaseMeta& meta) {
  const std::string application = fmt::format("PRAGMA application_id = {}", kApplicationId);
  const std::string version = fmt::format("PRAGMA user_version = {}", formatVersionOf(meta.scheme));
  for (const std::string_view sql :
       {std::string_view(application), std::string_view(version), kMetaTable, kSourcesTable, kTilesTable}) {
    if (auto ok = connection.execute(sql); !ok) return ok;
  }
  return hasFills(meta) ? connection.execute(kFillsTable) : io::Result<void>{};
}

/// Bytes. What a row leaves of its last page is lost: half a page of each, where rows are longer than pages. So pages
/// of elevation are small; pictures are a few times as large, and SQLite's 2^32 pages have to hold a planet of them.
int pageSizeFor(raster::Kind kind) {
  return kind == raster::Kind::elevation ? 1024 : 4096;
}

/// As many as the format can number. Debian's SQLite stops at a quarter of that unless told otherwise: at 1.1 TB of
/// elevation.
constexpr const char* kMostPages = "PRAGMA max_page_count = 4294967294";

/// What every writing connection needs so that the file's bytes depend on its content alone: no pages written before a
/// commit, a rollback journal that is gone after it.
io::Result<void> prepareWriting(const io::SqliteConnection& connection) {
  for (const std::string_view sql :
       {"PRAGMA auto_vacuum = 0", "PRAGMA encoding = 'UTF-8'", "PRAGMA journal_mode = DELETE",
        "PRAGMA synchronous = FULL", "PRAGMA cache_spill = OFF", "PRAGMA secure_delete = OFF", kMostPages}) {
    if (auto ok = connection.execute(sql); !ok) return ok;
  }
  return {};
}

template <class T>
bool parseNumber(std::string_view& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return true;
}

raster::HeightStatistics statisticsFrom(const io::SqliteStatement& row, int firstColumn) {
  const auto value = [&](int i) { return static_cast<float>(row.real(firstColumn + i)); };
  return {value(0), value(1), row.isNull(firstColumn + 2) ? 0.0f : value(2)};
}

}  // namespace

io::Result<TileDatabase> TileDatabase::open(const std::filesystem::path& path, io::SqliteConnection::Mode mode) {
  auto connection = io::SqliteConnection::open(path, mode);
  if (!connection) return tl::unexpected(connection.error());
  if (auto ok = checkSchema(*connection); !ok) return tl::unexpected(ok.error());
  if (mode != io::SqliteConnection::Mode::read) {
    if (auto ok = prepareWriting(*connection); !ok) return tl::unexpected(ok.error());
  }
  auto meta = readMeta(*connection);
  if (!meta) return tl::unexpected(meta.error());
  if (auto ok = checkVersion(*connection, meta->scheme); !ok) return tl::unexpected(ok.error());
  return TileDatabase(std::move(*connection), std::move(*meta));
}

io::Result<bool> TileDatabase::isBlank(const std::filesystem::path& path) {
  auto connection = io::SqliteConnection::open(path, io::SqliteConnection::Mode::write);
  if (!connection) return tl::unexpected(connection.error());
  const auto tables = connection->integer("SELECT count(*) FROM sqlite_schema");
  const auto application = connection->integer("PRAGMA application_id");
  if (!tables) return tl::unexpected(tables.error());
  if (!application) return tl::unexpected(application.error());
  return *tables == 0 && *application == 0;
}

io::Result<TileDatabase> TileDatabase::create(const std::filesystem::path& path, const DatabaseMeta& meta,
                                              const BuildPosition& start) {
  auto connection = io::SqliteConnection::open(path, io::SqliteConnection::Mode::create);
  if (!connection) return tl::unexpected(connection.error());
  const std::string pages = fmt::format("PRAGMA page_size = {}", pageSizeFor(meta.kind));
  if (auto ok = connection->execute(pages); !ok) return tl::unexpected(ok.error());
  if (auto ok = prepareWriting(*connection); !ok) return tl::unexpected(ok.error());
  TileDatabase database(std::move(*connection), meta);
  if (auto ok = database.begin(); !ok) return tl::unexpected(ok.error());
  if (auto ok = createTables(database.connection_, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = database.writeMeta(meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = database.writePosition(start); !ok) return tl::unexpected(ok.error());
  if (auto ok = database.commit(); !ok) return tl::unexpected(ok.error());
  return database;
}

io::Result<void> TileDatabase::writeMeta(const DatabaseMeta& meta) {
  if (auto ok = pyramid::writeMeta(connection_, meta); !ok) return ok;
  meta_ = meta;
  return {};
}

io::Result<std::optional<BuildPosition>> TileDatabase::position() const {
  auto row = connection_.prepare("SELECT value FROM meta WHERE key = 'progress'");
  if (!row) return tl::unexpected(row.error());
  const auto found = row->step();
  if (!found) return tl::unexpected(found.error());
  if (!*found) return std::optional<BuildPosition>{};
  const std::string text = row->text(0);
  std::string_view rest = text;
  BuildPosition position;
  if (!parseNumber(rest, position.level) || !parseNumber(rest, position.row) || !parseNumber(rest, position.done) ||
      position.level < 0 || position.level > tiling::kMaxLevel) {
    return io::fail(Code::corrupt, "the progress of the build cannot be read; remove the file to start over",
                    connection_.path());
  }
  return std::optional(position);
}

io::Result<void> TileDatabase::writePosition(const std::optional<BuildPosition>& position) {
  if (!position) return connection_.execute("DELETE FROM meta WHERE key = 'progress'");
  auto put =
      connection_.prepare("INSERT INTO meta VALUES ('progress', ?) ON CONFLICT DO UPDATE SET value = excluded.value");
  if (!put) return tl::unexpected(put.error());
  const std::string text = fmt::format("{} {} {}", position->level, position->row, position->done);
  put->bind(1, std::string_view(text));
  return put->run();
}

io::Result<io::SqliteStatement*> TileDatabase::prepared(std::optional<io::SqliteStatement>& slot,
                                                        std::string_view sql) {
  if (!slot) {
    auto statement = connection_.prepare(sql);
    if (!statement) return tl::unexpected(statement.error());
    slot = std::move(*statement);
  }
  return &*slot;
}

io::Result<std::optional<TileRecord>> TileDatabase::read(const tiling::TileId& id) {
  const auto statement = prepared(read_, fmt::format("SELECT {} FROM tiles WHERE id = ?", kTileColumns));
  if (!statement) return tl::unexpected(statement.error());
  io::SqliteStatement& select = **statement;
  select.bind(1, rowNumberOf(id));
  const auto found = select.step();
  if (!found) return tl::unexpected(found.error());
  if (!*found) return std::optional<TileRecord>{};
  auto record = recordFrom(select, meta_.kind, connection_.path());
  select.reset();
  if (!record) return tl::unexpected(record.error());
  return std::optional(std::move(*record));
}

io::Result<bool> TileDatabase::contains(const tiling::TileId& id) {
  const auto statement = prepared(contains_, "SELECT 1 FROM tiles WHERE id = ?");
  if (!statement) return tl::unexpected(statement.error());
  (*statement)->bind(1, rowNumberOf(id));
  const auto found = (*statement)->step();
  (*statement)->reset();
  return found;
}

io::Result<void> TileDatabase::write(const TileRecord& record) {
  const auto statement = prepared(write_, "INSERT OR REPLACE INTO tiles VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!statement) return tl::unexpected(statement.error());
  io::SqliteStatement& insert = **statement;
  const auto integer = [](auto value) { return static_cast<std::int64_t>(value); };
  insert.bind(1, rowNumberOf(record.id)).bind(2, integer(record.id.level)).bind(3, integer(record.id.root));
  insert.bind(4, integer(record.id.x)).bind(5, integer(record.id.y)).bind(9, integer(record.childMask));
  if (meta_.kind == raster::Kind::elevation) {
    insert.bind(6, static_cast<double>(record.statistics.min_m)).bind(7, static_cast<double>(record.statistics.max_m));
    insert.bind(8, static_cast<double>(record.statistics.error_m));
    insert.bind(10, std::span<const std::byte>(childrenBytes(record.children)));
  }
  insert.bind(11, integer(checksumOf(record, meta_.kind))).bind(12, std::span<const std::byte>(record.payload));
  if (auto ok = insert.run(); !ok) return ok;
  return hasFills(meta_) ? writeDepths(record) : io::Result<void>{};
}

io::Result<void> TileDatabase::writeDepths(const TileRecord& record) {
  if (record.depths.empty()) {
    const auto statement = prepared(removeDepths_, "DELETE FROM fills WHERE id = ?");
    if (!statement) return tl::unexpected(statement.error());
    (*statement)->bind(1, rowNumberOf(record.id));
    return (*statement)->run();
  }
  const auto statement = prepared(writeDepths_, "INSERT OR REPLACE INTO fills VALUES (?, ?)");
  if (!statement) return tl::unexpected(statement.error());
  (*statement)->bind(1, rowNumberOf(record.id)).bind(2, std::span<const std::byte>(record.depths));
  return (*statement)->run();
}

io::Result<std::optional<raster::Raster<float>>> TileDatabase::depths(const tiling::TileId& id) {
  using Depths = std::optional<raster::Raster<float>>;
  if (!hasFills(meta_)) return Depths{};
  const auto statement = prepared(readDepths_, "SELECT depths FROM fills WHERE id = ?");
  if (!statement) return tl::unexpected(statement.error());
  io::SqliteStatement& select = **statement;
  select.bind(1, rowNumberOf(id));
  const auto found = select.step();
  if (!found) return tl::unexpected(found.error());
  if (!*found) {
    select.reset();
    return Depths{};
  }
  const int side = sideOf(raster::Kind::elevation, meta_.tileCells);
  auto depths = raster::decodeElevation(select.blob(0), side, side);
  select.reset();
  const auto isWrong = [&](float depth) { return !raster::isNoData(depth) && !(depth >= 0.0f && depth < id.level); };
  if (!depths || std::ranges::any_of(depths->samples, isWrong)) {
    return io::fail(Code::corrupt, fmt::format("{}: the depths of what was filled in it are damaged", nameOf(id)),
                    connection_.path());
  }
  return Depths(std::move(*depths));
}

std::vector<std::byte> encodedDepths(const raster::Raster<float>& depths) {
  if (std::ranges::all_of(depths.samples, raster::isNoData)) return {};
  return raster::encodeElevation(depths, kDepthStep);
}

io::Result<TileRecord> recordFrom(const io::SqliteStatement& row, raster::Kind kind, const std::string& where) {
  const auto id = tileOfRowNumber(row.integer(0));
  if (!id) return io::fail(Code::corrupt, fmt::format("row {} belongs to no tile", row.integer(0)), where);
  const auto complain = [&](const std::string& what) {
    return io::fail(Code::corrupt, fmt::format("{}: {}", nameOf(*id), what), where);
  };
  if (row.integer(1) != id->level || row.integer(2) != id->root || row.integer(3) != std::int64_t{id->x} ||
      row.integer(4) != std::int64_t{id->y}) {
    return complain("its row number and its place disagree");
  }
  if (row.integer(8) < 0 || row.integer(8) > 15) return complain("impossible mask of children");
  TileRecord record;
  record.id = *id;
  record.childMask = static_cast<std::uint8_t>(row.integer(8));
  if (kind == raster::Kind::elevation) {
    record.statistics = statisticsFrom(row, 5);
    const std::span<const std::byte> children = row.blob(9);
    if (children.size() != kChildrenBytes) return complain("the children's statistics have a wrong length");
    record.children = childrenFromBytes(children.first<kChildrenBytes>());
  }
  const std::span<const std::byte> payload = row.blob(11);
  record.payload.assign(payload.begin(), payload.end());
  if (row.integer(10) != std::int64_t{checksumOf(record, kind)}) return complain("wrong checksum: damaged");
  return record;
}

}  // namespace tellurion::pyramid
