#include "pyramid/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr std::string_view kShardTable = "CREATE TABLE shard (number INTEGER PRIMARY KEY, key TEXT NOT NULL, value)";
constexpr std::string_view kPiecesTable = "CREATE TABLE pieces (id INTEGER PRIMARY KEY, candidates INTEGER NOT NULL)";
constexpr std::int64_t kMostCandidates = 1 << 20;
constexpr std::size_t kMostPartsNamed = 8;

/// Rows of the table `shard`. After the first failure nothing more is written.
class Writer {
 public:
  explicit Writer(const TileDatabase& database) : database_(database) {}
  template <class T>
  void put(std::string_view key, const T& value) {
    if (!ok_) return;
    auto row = database_.connection().prepare("INSERT INTO shard (key, value) VALUES (?, ?)");
    if (!row) {
      ok_ = tl::unexpected(row.error());
      return;
    }
    row->bind(1, key).bind(2, value);
    ok_ = row->run();
  }
  void put(std::string_view key, const std::string& value) { put(key, std::string_view(value)); }
  io::Result<void> result() const { return ok_; }

 private:
  const TileDatabase& database_;
  io::Result<void> ok_;
};

void writeRequest(const BuildOptions& options, Writer& writer) {
  for (const std::string& input : options.inputs)
    writer.put("input", input);
  writer.put("body_is_named", std::int64_t{options.body.has_value()});
  if (options.maxLevel) writer.put("max_level", std::int64_t{*options.maxLevel});
  if (options.nodata) {
    writer.put("nodata", fmt::format("{:a}", *options.nodata));  // as text: it may be NaN
  }
  if (options.fillVoids_m) writer.put("fill_voids_m", *options.fillVoids_m);
  if (options.maxError_m) writer.put("max_error_m", *options.maxError_m);
  writer.put("vertical_datum", options.verticalDatum);
  for (const std::string& column : options.points.columns)
    writer.put("points_column", column);
  writer.put("points_srs", options.points.reference);
  writer.put("match_colours", std::int64_t{options.cleaning.matchColours});
  writer.put("feather_m", options.cleaning.feather_m);
  for (const std::string& file : options.cleaning.cutAt)
    writer.put("cut", file);
  writer.put("clouds", std::int64_t{options.cleaning.clouds});
  if (options.region) {
    writer.put("south", options.region->south.radians());
    writer.put("north", options.region->north.radians());
    writer.put("west", options.region->west.radians());
    writer.put("width", options.region->width.radians());
  }
  writer.put("format", std::string(nameOf(options.format)));
}

/// One row of the request; keys that are not known are left alone. The builder checks the options themselves.
void readRow(const io::SqliteStatement& row, const geo::Body& body, ShardRequest& request, geo::GeoRect& region) {
  BuildOptions& options = request.options;
  const std::string key = row.text(0);
  const double real = row.real(1);
  const auto isOn = [&] { return row.integer(1) != 0; };
  if (key == "folder") request.folder = row.text(1);
  if (key == "input") options.inputs.push_back(row.text(1));
  if (key == "body_is_named" && isOn()) options.body = body;
  if (key == "max_level") options.maxLevel = static_cast<int>(std::clamp<std::int64_t>(row.integer(1), -1, 1000));
  if (key == "nodata") options.nodata = std::strtod(row.text(1).c_str(), nullptr);
  if (key == "fill_voids_m") options.fillVoids_m = real;
  if (key == "max_error_m") options.maxError_m = real;
  if (key == "vertical_datum") options.verticalDatum = row.text(1);
  if (key == "points_column") options.points.columns.push_back(row.text(1));
  if (key == "points_srs") options.points.reference = row.text(1);
  if (key == "match_colours") options.cleaning.matchColours = isOn();
  if (key == "feather_m") options.cleaning.feather_m = real;
  if (key == "cut") options.cleaning.cutAt.push_back(row.text(1));
  if (key == "clouds") options.cleaning.clouds = isOn();
  if (key == "south") region.south = geo::Angle::radians(real);
  if (key == "north") region.north = geo::Angle::radians(real);
  if (key == "west") region.west = geo::Angle::radians(real);
  if (key == "width") options.region = geo::GeoRect{region.south, region.north, region.west, geo::Angle::radians(real)};
  if (key == "format") options.format = tileFormatByName(row.text(1)).value_or(TileFormat::jpeg);
}

io::Result<TileDatabase> openShard(const fs::path& path) {
  auto database = TileDatabase::open(path, io::SqliteConnection::Mode::read);
  if (!database) return database;
  if (!isShard(*database)) {
    return io::fail(Code::invalidArgument,
                    database->meta().complete
                        ? "is a finished tile database and not a part of one; what is joined are the parts that 'build "
                          "--part' makes. To lay rasters over it: 'build --append'; to see several databases at once, "
                          "join their names by commas"
                        : "is a build of its own that is not finished, and not a part of one",
                    path.string());
  }
  return database;
}

/// The part that a finished shard of the plan is.
io::Result<tiling::TileId> partOf(const fs::path& path, const BuildPlan& plan) {
  const auto database = openShard(path);
  if (!database) return tl::unexpected(database.error());
  if (database->meta().buildKey != plan.meta.buildKey) {
    return io::fail(Code::invalidArgument,
                    "is of another build: other inputs or options, or an input has changed since; make it again",
                    path.string());
  }
  const auto finished = database->connection().integer("SELECT count(*) FROM shard WHERE key = 'finished'");
  if (!finished) return tl::unexpected(finished.error());
  if (*finished == 0) {
    return io::fail(Code::invalidArgument, "is not finished; the command that makes it goes on with it", path.string());
  }
  const auto row = database->connection().integer("SELECT value FROM shard WHERE key = 'part'");
  if (!row) return tl::unexpected(row.error());
  const auto part = tileOfRowNumber(*row);
  if (!part) return io::fail(Code::corrupt, "does not say which part it is; make it again", path.string());
  return *part;
}

}  // namespace

bool isShard(const TileDatabase& database) {
  const auto tables = database.connection().integer(
      "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name IN ('shard', 'pieces')");
  return tables && *tables == 2;
}

io::Result<void> makeShard(TileDatabase& database, const BuildOptions& options, const tiling::TileId& part) {
  if (isShard(database)) return {};
  if (auto ok = database.begin(); !ok) return ok;
  auto ok = database.connection().execute(kShardTable);
  if (ok) ok = database.connection().execute(kPiecesTable);
  if (ok) {
    Writer writer(database);
    std::error_code error;
    writer.put("part", rowNumberOf(part));
    writer.put("folder", fs::current_path(error).string());
    writeRequest(options, writer);
    ok = writer.result();
  }
  if (ok) ok = database.commit();
  if (!ok) database.rollback();
  return ok;
}

io::Result<void> listPiece(TileDatabase& database, const tiling::TileId& piece, std::uint64_t candidates) {
  auto row = database.connection().prepare("INSERT INTO pieces VALUES (?, ?)");
  if (!row) return tl::unexpected(row.error());
  row->bind(1, rowNumberOf(piece)).bind(2, static_cast<std::int64_t>(candidates));
  return row->run();
}

io::Result<void> finishShard(TileDatabase& database) {
  return database.connection().execute("INSERT INTO shard (key, value) VALUES ('finished', 1)");
}

io::Result<ShardRequest> requestOf(const fs::path& shard) {
  const auto database = openShard(shard);
  if (!database) return tl::unexpected(database.error());
  auto rows = database->connection().prepare("SELECT key, value FROM shard ORDER BY number");
  if (!rows) return tl::unexpected(rows.error());
  ShardRequest request;
  request.options.kind = database->meta().kind;
  request.options.scheme = database->meta().scheme;
  geo::GeoRect region{};
  while (true) {
    const auto more = rows->step();
    if (!more) return tl::unexpected(more.error());
    if (!*more) break;
    readRow(*rows, database->meta().body, request, region);
  }
  return request;
}

io::Result<ShardSet> ShardSet::open(std::span<const fs::path> shards, const BuildPlan& plan,
                                    std::span<const tiling::TileId> parts) {
  ShardSet set(plan.deepestLevel);
  for (const fs::path& path : shards) {
    const auto part = partOf(path, plan);
    if (!part) return tl::unexpected(part.error());
    if (std::ranges::find(parts, *part) == parts.end())
      return io::fail(Code::corrupt, "is no part of its build; make it again", path.string());
    const auto [other, isNew] = set.paths_.emplace(*part, path);
    if (!isNew) {
      return io::fail(Code::invalidArgument,
                      fmt::format("is the same part as {}: leave one out", other->second.string()), path.string());
    }
  }
  std::string missing;
  std::size_t count = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    set.partLevel_ = parts[i].level;
    if (set.paths_.contains(parts[i])) continue;
    if (++count <= kMostPartsNamed) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", i + 1);
  }
  if (count == 0) return set;
  return io::fail(Code::invalidArgument,
                  fmt::format("{} of the build's {} parts are missing ({}{}): make them with 'build --part' and name "
                              "them all",
                              count, parts.size(), missing, count > kMostPartsNamed ? ", ..." : ""));
}

io::Result<MadeTiles> ShardSet::piece(const tiling::TileId& id) {
  const tiling::TileId part = id.ancestor(partLevel_);
  const auto path = paths_.find(part);
  if (path == paths_.end()) return io::fail(Code::corrupt, fmt::format("{} is in no part of the build", nameOf(id)));
  if (!open_ || openPart_ != part) {
    auto database = TileDatabase::open(path->second, io::SqliteConnection::Mode::read);
    if (!database) return tl::unexpected(database.error());
    open_.emplace(std::move(*database));
    openPart_ = part;
  }
  const std::string where = path->second.string();
  auto row = open_->connection().prepare("SELECT candidates FROM pieces WHERE id = ?");
  if (!row) return tl::unexpected(row.error());
  row->bind(1, rowNumberOf(id));
  const auto found = row->step();
  if (!found) return tl::unexpected(found.error());
  if (!*found || row->integer(0) < 1 || row->integer(0) > kMostCandidates) {
    return io::fail(Code::corrupt, fmt::format("does not hold {}; remove it and make it again", nameOf(id)), where);
  }
  MadeTiles made{.records = {}, .candidates = static_cast<std::uint64_t>(row->integer(0))};
  const auto holds = open_->contains(id);
  if (!holds) return tl::unexpected(holds.error());
  if (!*holds) return made;
  if (auto ok = readFamily(id, made); !ok) {
    ok.error().message += "; remove it and make it again";
    return tl::unexpected(ok.error());
  }
  return made;
}

/// Children before their parents, as TileMaker makes them.
io::Result<void> ShardSet::readFamily(const tiling::TileId& id, MadeTiles& made) {
  auto record = open_->read(id);
  if (!record) return tl::unexpected(record.error());
  if (!*record || (id.level >= deepestLevel_ && (*record)->childMask != 0)) {
    return io::fail(Code::corrupt, fmt::format("{} and its parent disagree on whether there is one", nameOf(id)),
                    open_->connection().path());
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    if (((*record)->childMask & (1 << quadrant)) == 0) continue;
    if (auto ok = readFamily(id.child(quadrant), made); !ok) return ok;
  }
  const auto depths = open_->depths(id);
  if (!depths) return tl::unexpected(depths.error());
  if (*depths) (*record)->depths = encodedDepths(**depths);
  made.records.push_back(std::move(**record));
  return {};
}

}  // namespace tellurion::pyramid
