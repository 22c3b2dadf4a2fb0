#include "pyramid/database_meta.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <map>
#include <string_view>

#include "pyramid/bounded_heights.h"
#include "pyramid/fill_plan.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

constexpr std::int64_t kMostSources = 1'000'000;

/// The table of names and values, read whole.
struct MetaTable {
  std::string where;
  std::map<std::string, std::string, std::less<>> texts;
  std::map<std::string, double, std::less<>> numbers;

  io::Result<std::string> text(std::string_view key) const {
    const auto found = texts.find(key);
    if (found != texts.end()) return found->second;
    return io::fail(Code::corrupt, fmt::format("the table 'meta' lacks a text '{}'", key), where);
  }
  io::Result<double> number(std::string_view key, double low, double high) const {
    const auto found = numbers.find(key);
    if (found == numbers.end()) {
      return io::fail(Code::corrupt, fmt::format("the table 'meta' lacks a number '{}'", key), where);
    }
    if (found->second >= low && found->second <= high) return found->second;
    return io::fail(Code::corrupt, fmt::format("'{}' in the table 'meta' is out of its range", key), where);
  }
};

io::Result<MetaTable> readTable(const io::SqliteConnection& connection) {
  MetaTable table{.where = connection.path(), .texts = {}, .numbers = {}};
  auto rows = connection.prepare("SELECT key, value, typeof(value) FROM meta LIMIT 1000");
  if (!rows) return tl::unexpected(rows.error());
  while (true) {
    const auto row = rows->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return table;
    if (rows->text(2) == "text") {
      table.texts[rows->text(0)] = rows->text(1);
    } else {
      table.numbers[rows->text(0)] = rows->real(1);
    }
  }
}

io::Result<std::vector<std::string>> readSources(const io::SqliteConnection& connection) {
  std::vector<std::string> sources;
  auto rows = connection.prepare(fmt::format("SELECT path FROM sources ORDER BY number LIMIT {}", kMostSources));
  if (!rows) return tl::unexpected(rows.error());
  while (true) {
    const auto row = rows->step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return sources;
    sources.push_back(rows->text(0));
  }
}

constexpr int kMostElevationCells = 128;  ///< what a terrain mesh is made of

io::Result<void> parseShape(const MetaTable& table, DatabaseMeta& meta) {
  const auto kindName = table.text("kind");
  const auto schemeName = table.text("tiling");
  if (!kindName) return tl::unexpected(kindName.error());
  if (!schemeName) return tl::unexpected(schemeName.error());
  const auto kind = raster::kindByName(*kindName);
  const auto scheme = tiling::schemeByName(*schemeName);
  if (!kind) return io::fail(Code::corrupt, "unknown kind of samples", table.where);
  if (!scheme) return io::fail(Code::corrupt, "unknown tiling", table.where);
  meta.kind = *kind;
  meta.scheme = *scheme;
  const auto cells = table.number("tile_cells", 4, 1024);
  const auto maxLevel = table.number("max_level", 0, tiling::kMaxLevel);
  if (!cells) return tl::unexpected(cells.error());
  if (!maxLevel) return tl::unexpected(maxLevel.error());
  meta.tileCells = static_cast<int>(*cells);
  meta.maxLevel = static_cast<int>(*maxLevel);
  if (!std::has_single_bit(static_cast<unsigned>(meta.tileCells))) {
    return io::fail(Code::corrupt, "the tiles' size is not a power of two", table.where);
  }
  if (meta.kind == raster::Kind::elevation && meta.tileCells > kMostElevationCells) {
    return io::fail(Code::unsupported,
                    fmt::format("elevation in tiles of {} cells a side; this program takes 4 to {}: build it again",
                                meta.tileCells, kMostElevationCells),
                    table.where);
  }
  return {};
}

io::Result<void> parsePlace(const MetaTable& table, DatabaseMeta& meta) {
  const auto name = table.text("body_name");
  if (!name) return tl::unexpected(name.error());
  constexpr std::array<std::string_view, 7> kKeys = {"body_semi_major_axis_m", "body_flattening", "south_degrees",
                                                     "west_degrees",           "north_degrees",   "width_degrees",
                                                     "height_step_m"};
  constexpr std::array<double, 7> kLow = {1e-3, 0.0, -90.0, -180.0, -90.0, 0.0, 0.0};
  constexpr std::array<double, 7> kHigh = {1e12, 0.99, 90.0, 180.0, 90.0, 360.0, 1e9};
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = table.number(kKeys[i], kLow[i], kHigh[i]);
    if (!value) return tl::unexpected(value.error());
    values[i] = *value;
  }
  meta.body = geo::Body{*name, geo::Ellipsoid(values[0], values[1])};
  meta.bounds = geo::GeoRect{.south = geo::Angle::degrees(values[2]),
                             .north = geo::Angle::degrees(values[4]),
                             .west = geo::Angle::degrees(values[3]),
                             .width = geo::Angle::degrees(values[5])};
  meta.heightStep_m = values[6];
  return {};
}

/// Files of before voids were filled do not tell.
io::Result<void> parseFill(const MetaTable& table, DatabaseMeta& meta) {
  if (!table.numbers.contains("fill_voids_m")) return {};
  const auto limit = table.number("fill_voids_m", 0.0, kFillWithoutLimit_m);
  const auto from = table.number("fill_from_level", 0, tiling::kMaxLevel);
  if (!limit) return tl::unexpected(limit.error());
  if (!from) return tl::unexpected(from.error());
  meta.fillVoids_m = *limit;
  meta.fillFromLevel = static_cast<int>(*from);
  return {};
}

io::Result<void> parseMaxError(const MetaTable& table, DatabaseMeta& meta) {
  if (!table.numbers.contains("max_error_m")) return {};
  const auto error = table.number("max_error_m", 0.0, kMostMaxError_m);
  if (!error) return tl::unexpected(error.error());
  meta.maxError_m = *error;
  return {};
}

/// Stops at the first failure and keeps it.
class MetaWriter {
 public:
  explicit MetaWriter(const io::SqliteConnection& connection)
      : statement_(
            connection.prepare("INSERT INTO meta VALUES (?, ?) ON CONFLICT DO UPDATE SET value = excluded.value")) {}
  template <class T>
  void put(std::string_view key, T value) {
    if (!statement_ || !result_) return;
    statement_->bind(1, key).bind(2, value);
    result_ = statement_->run();
  }
  io::Result<void> result() const {
    if (!statement_) return tl::unexpected(statement_.error());
    return result_;
  }

 private:
  io::Result<io::SqliteStatement> statement_;
  io::Result<void> result_;
};

io::Result<void> writeSources(const io::SqliteConnection& connection, const std::vector<std::string>& sources) {
  auto insert = connection.prepare("INSERT OR IGNORE INTO sources VALUES (?, ?)");
  if (!insert) return tl::unexpected(insert.error());
  std::int64_t number = 0;
  for (const std::string& source : sources) {
    insert->bind(1, ++number).bind(2, std::string_view(source));
    if (auto ok = insert->run(); !ok) return ok;
  }
  return {};
}

}  // namespace

std::int64_t formatVersionOf(tiling::Scheme scheme) {
  // In version 1 the geographic tiling had two roots of 180 degrees. The others are what they were.
  return scheme == tiling::Scheme::geographic ? 2 : 1;
}

io::Result<DatabaseMeta> readMeta(const io::SqliteConnection& connection) {
  const auto table = readTable(connection);
  if (!table) return tl::unexpected(table.error());
  DatabaseMeta meta;
  if (auto ok = parseShape(*table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parsePlace(*table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parseFill(*table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parseMaxError(*table, meta); !ok) return tl::unexpected(ok.error());
  const auto complete = table->number("complete", 0, 1);
  const auto buildKey = table->text("build_key");
  const auto requestKey = table->text("request_key");
  auto sources = readSources(connection);
  if (!complete) return tl::unexpected(complete.error());
  if (!buildKey) return tl::unexpected(buildKey.error());
  if (!requestKey) return tl::unexpected(requestKey.error());
  if (!sources) return tl::unexpected(sources.error());
  meta.complete = *complete != 0.0;
  meta.buildKey = *buildKey;
  meta.requestKey = *requestKey;
  meta.sources = std::move(*sources);
  return meta;
}

io::Result<void> writeMeta(const io::SqliteConnection& connection, const DatabaseMeta& meta) {
  MetaWriter writer(connection);
  writer.put("kind", raster::nameOf(meta.kind));
  writer.put("tiling", tiling::nameOf(meta.scheme));
  writer.put("body_name", std::string_view(meta.body.name));
  writer.put("body_semi_major_axis_m", meta.body.ellipsoid.semiMajorAxis_m());
  writer.put("body_flattening", meta.body.ellipsoid.flattening());
  writer.put("tile_cells", std::int64_t{meta.tileCells});
  writer.put("max_level", std::int64_t{meta.maxLevel});
  writer.put("south_degrees", meta.bounds.south.degrees());
  writer.put("west_degrees", meta.bounds.west.degrees());
  writer.put("north_degrees", meta.bounds.north.degrees());
  writer.put("width_degrees", meta.bounds.width.degrees());
  writer.put("height_step_m", meta.heightStep_m);
  if (meta.kind == raster::Kind::elevation) {
    writer.put("fill_voids_m", meta.fillVoids_m);
    writer.put("fill_from_level", std::int64_t{meta.fillFromLevel});
    if (meta.maxError_m > 0.0) writer.put("max_error_m", meta.maxError_m);
  }
  writer.put("complete", std::int64_t{meta.complete ? 1 : 0});
  writer.put("build_key", std::string_view(meta.buildKey));
  writer.put("request_key", std::string_view(meta.requestKey));
  if (auto ok = writer.result(); !ok) return ok;
  return writeSources(connection, meta.sources);
}

}  // namespace tellurion::pyramid
