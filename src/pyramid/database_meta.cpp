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

io::Result<std::string> textIn(const MetaTable& table, std::string_view key) {
  const auto found = table.texts.find(key);
  if (found != table.texts.end()) return found->second;
  return io::fail(Code::corrupt, fmt::format("the table 'meta' lacks a text '{}'", key), table.where);
}

io::Result<double> numberIn(const MetaTable& table, std::string_view key, double low, double high) {
  const auto found = table.numbers.find(key);
  if (found == table.numbers.end())
    return io::fail(Code::corrupt, fmt::format("the table 'meta' lacks a number '{}'", key), table.where);
  if (found->second >= low && found->second <= high) return found->second;
  return io::fail(Code::corrupt, fmt::format("'{}' in the table 'meta' is out of its range", key), table.where);
}

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
  const auto kindName = textIn(table, "kind");
  const auto schemeName = textIn(table, "tiling");
  if (!kindName) return tl::unexpected(kindName.error());
  if (!schemeName) return tl::unexpected(schemeName.error());
  const auto kind = raster::kindByName(*kindName);
  const auto scheme = tiling::schemeByName(*schemeName);
  if (!kind) return io::fail(Code::corrupt, "unknown kind of samples", table.where);
  if (!scheme) return io::fail(Code::corrupt, "unknown tiling", table.where);
  meta.kind = *kind;
  meta.scheme = *scheme;
  const auto cells = numberIn(table, "tile_cells", 4, 1024);
  const auto maxLevel = numberIn(table, "max_level", 0, tiling::kMaxLevel);
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
  const auto name = textIn(table, "body_name");
  if (!name) return tl::unexpected(name.error());
  constexpr std::array<std::string_view, 7> kKeys = {"body_semi_major_axis_m", "body_flattening", "south_degrees",
                                                     "west_degrees",           "north_degrees",   "width_degrees",
                                                     "height_step_m"};
  constexpr std::array<double, 7> kLow = {1e-3, 0.0, -90.0, -180.0, -90.0, 0.0, 0.0};
  constexpr std::array<double, 7> kHigh = {1e12, 0.99, 90.0, 180.0, 90.0, 360.0, 1e9};
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    const auto value = numberIn(table, kKeys[i], kLow[i], kHigh[i]);
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
  const auto limit = numberIn(table, "fill_voids_m", 0.0, kFillWithoutLimit_m);
  const auto from = numberIn(table, "fill_from_level", 0, tiling::kMaxLevel);
  if (!limit) return tl::unexpected(limit.error());
  if (!from) return tl::unexpected(from.error());
  meta.fillVoids_m = *limit;
  meta.fillFromLevel = static_cast<int>(*from);
  return {};
}

io::Result<void> parseMaxError(const MetaTable& table, DatabaseMeta& meta) {
  if (!table.numbers.contains("max_error_m")) return {};
  const auto error = numberIn(table, "max_error_m", 0.0, kMostMaxError_m);
  if (!error) return tl::unexpected(error.error());
  meta.maxError_m = *error;
  return {};
}

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

std::vector<std::pair<std::string_view, MetaValue>> valuesForReading(const DatabaseMeta& meta) {
  std::vector<std::pair<std::string_view, MetaValue>> values{
      {"kind", std::string(raster::nameOf(meta.kind))},
      {"tiling", std::string(tiling::nameOf(meta.scheme))},
      {"body_name", meta.body.name},
      {"body_semi_major_axis_m", meta.body.ellipsoid.semiMajorAxis_m()},
      {"body_flattening", meta.body.ellipsoid.flattening()},
      {"tile_cells", std::int64_t{meta.tileCells}},
      {"max_level", std::int64_t{meta.maxLevel}},
      {"south_degrees", meta.bounds.south.degrees()},
      {"west_degrees", meta.bounds.west.degrees()},
      {"north_degrees", meta.bounds.north.degrees()},
      {"width_degrees", meta.bounds.width.degrees()},
      {"height_step_m", meta.heightStep_m}};
  if (meta.kind == raster::Kind::elevation) {
    values.emplace_back("fill_voids_m", meta.fillVoids_m);
    values.emplace_back("fill_from_level", std::int64_t{meta.fillFromLevel});
    if (meta.maxError_m > 0.0) values.emplace_back("max_error_m", meta.maxError_m);
  }
  return values;
}

io::Result<DatabaseMeta> metaForReading(const MetaTable& table) {
  DatabaseMeta meta;
  if (auto ok = parseShape(table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parsePlace(table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parseFill(table, meta); !ok) return tl::unexpected(ok.error());
  if (auto ok = parseMaxError(table, meta); !ok) return tl::unexpected(ok.error());
  return meta;
}

raster::TileSourceInfo sourceInfoOf(std::string name, const DatabaseMeta& meta) {
  return {.name = std::move(name),
          .kind = meta.kind,
          .scheme = meta.scheme,
          .body = meta.body,
          .tileCells = meta.tileCells,
          .maxLevel = meta.maxLevel,
          .bounds = meta.bounds};
}

io::Result<DatabaseMeta> readMeta(const io::SqliteConnection& connection) {
  const auto table = readTable(connection);
  if (!table) return tl::unexpected(table.error());
  auto read = metaForReading(*table);
  if (!read) return read;
  DatabaseMeta& meta = *read;
  const auto complete = numberIn(*table, "complete", 0, 1);
  const auto buildKey = textIn(*table, "build_key");
  const auto requestKey = textIn(*table, "request_key");
  auto sources = readSources(connection);
  if (!complete) return tl::unexpected(complete.error());
  if (!buildKey) return tl::unexpected(buildKey.error());
  if (!requestKey) return tl::unexpected(requestKey.error());
  if (!sources) return tl::unexpected(sources.error());
  meta.complete = *complete != 0.0;
  meta.buildKey = *buildKey;
  meta.requestKey = *requestKey;
  meta.sources = std::move(*sources);
  return read;
}

io::Result<void> writeMeta(const io::SqliteConnection& connection, const DatabaseMeta& meta) {
  auto values = valuesForReading(meta);
  values.emplace_back("complete", std::int64_t{meta.complete ? 1 : 0});
  values.emplace_back("build_key", meta.buildKey);
  values.emplace_back("request_key", meta.requestKey);
  auto put = connection.prepare("INSERT INTO meta VALUES (?, ?) ON CONFLICT DO UPDATE SET value = excluded.value");
  if (!put) return tl::unexpected(put.error());
  for (const auto& [key, value] : values) {
    put->bind(1, key);
    std::visit([&](const auto& typed) { put->bind(2, typed); }, value);
    if (auto ok = put->run(); !ok) return ok;
  }
  return writeSources(connection, meta.sources);
}

}  // namespace tellurion::pyramid
