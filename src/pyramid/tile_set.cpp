#include "pyramid/tile_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <utility>

#include "io/sqlite.h"
#include "pyramid/export_place.h"

namespace tellurion::pyramid {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;

constexpr int kTilesOfACommit = 256;

io::Result<void> runAll(const io::SqliteConnection& connection, std::initializer_list<std::string_view> statements) {
  for (const std::string_view statement : statements)
    if (auto ok = connection.execute(statement); !ok) return ok;
  return {};
}

class Mbtiles final : public TileSet {
 public:
  static io::Result<std::unique_ptr<TileSet>> create(const fs::path& path, const TileSetFacts& facts) {
    auto connection = io::SqliteConnection::open(path, io::SqliteConnection::Mode::create);
    if (!connection) return tl::unexpected(connection.error());
    // The file is nobody's until it is renamed: nothing to roll back to.
    if (auto ok =
            runAll(*connection, {"PRAGMA journal_mode = OFF", "PRAGMA synchronous = OFF",
                                 "PRAGMA application_id = 0x4d504258", "CREATE TABLE metadata (name TEXT, value TEXT)",
                                 "CREATE TABLE tiles (zoom_level INTEGER, tile_column INTEGER, tile_row INTEGER, "
                                 "tile_data BLOB)"});
        !ok) {
      return tl::unexpected(ok.error());
    }
    auto insert = connection->prepare("INSERT INTO tiles VALUES (?, ?, ?, ?)");
    if (!insert) return tl::unexpected(insert.error());
    std::unique_ptr<Mbtiles> set(new Mbtiles(std::move(*connection), std::move(*insert)));
    if (auto ok = set->describe(facts); !ok) return tl::unexpected(ok.error());
    if (auto ok = set->connection_.execute("BEGIN"); !ok) return tl::unexpected(ok.error());
    return std::unique_ptr<TileSet>(std::move(set));
  }

  io::Result<void> put(const MapTile& tile, std::span<const std::byte> bytes) override {
    insert_.bind(1, std::int64_t{tile.zoom})
        .bind(2, tile.x)
        .bind(3, mapRows(MapScheme::mercator, tile.zoom) - 1 - tile.y)
        .bind(4, bytes);
    if (auto ok = insert_.run(); !ok) return ok;
    if (++sinceCommit_ < kTilesOfACommit) return {};
    sinceCommit_ = 0;
    return runAll(connection_, {"COMMIT", "BEGIN"});
  }

  io::Result<void> finish() override {
    return runAll(connection_,
                  {"COMMIT", "CREATE UNIQUE INDEX tile_index ON tiles (zoom_level, tile_column, tile_row)"});
  }

 private:
  Mbtiles(io::SqliteConnection connection, io::SqliteStatement insert)
      : connection_(std::move(connection)), insert_(std::move(insert)) {}

  io::Result<void> describe(const TileSetFacts& facts) {
    auto insert = connection_.prepare("INSERT INTO metadata VALUES (?, ?)");
    if (!insert) return tl::unexpected(insert.error());
    const std::pair<std::string_view, std::string> rows[] = {{"name", facts.name},
                                                             {"format", endingOf(facts.format)},
                                                             {"type", "baselayer"},
                                                             {"version", "1"},
                                                             {"description", "exported from a tile database"},
                                                             {"minzoom", fmt::format("{}", facts.minZoom)},
                                                             {"maxzoom", fmt::format("{}", facts.maxZoom)},
                                                             {"bounds", boundsText(facts)}};
    for (const auto& [name, value] : rows) {
      insert->bind(1, name).bind(2, std::string_view(value));
      if (auto ok = insert->run(); !ok) return ok;
    }
    return {};
  }

  io::SqliteConnection connection_;
  io::SqliteStatement insert_;  // ends before its connection
  int sinceCommit_ = 0;
};

class TileFolder final : public TileSet {
 public:
  TileFolder(fs::path path, TileSetFacts facts) : path_(std::move(path)), facts_(std::move(facts)) {}

  io::Result<void> put(const MapTile& tile, std::span<const std::byte> bytes) override {
    const std::string name = fmt::format("{}/{}/{}.{}", tile.zoom, tile.x, tile.y, endingOf(facts_.format));
    return writeWholeFile(path_ / name, bytes);
  }

  io::Result<void> finish() override {
    const std::string text = fmt::format(
        "{{\n  \"generator\": \"{}\",\n  \"tilejson\": \"3.0.0\",\n  \"tiles\": [\"{{z}}/{{x}}/{{y}}.{}\"],\n  "
        "\"scheme\": \"xyz\",\n"
        "  \"projection\": \"{}\",\n  \"minzoom\": {},\n  \"maxzoom\": {},\n  \"bounds\": [{}]\n}}\n",
        kGenerator, endingOf(facts_.format), facts_.scheme == MapScheme::mercator ? "EPSG:3857" : "EPSG:4326",
        facts_.minZoom, facts_.maxZoom, boundsText(facts_));
    return writeWholeFile(path_ / kTileJsonName, std::as_bytes(std::span(text)));
  }

 private:
  fs::path path_;
  TileSetFacts facts_;
};

}  // namespace

std::string boundsText(const TileSetFacts& facts) {
  const double most = facts.scheme == MapScheme::mercator ? rectOf(facts.scheme, {}).north.degrees() : 90.0;
  const double west = facts.bounds.west.degrees();
  const double east = west + facts.bounds.width.degrees();
  const bool isAround = east > 180.0 + 1e-9;
  return fmt::format("{:.9g},{:.9g},{:.9g},{:.9g}", isAround ? -180.0 : west,
                     std::clamp(facts.bounds.south.degrees(), -most, most), isAround ? 180.0 : std::min(east, 180.0),
                     std::clamp(facts.bounds.north.degrees(), -most, most));
}

std::string endingOf(raster::ImageFormat format) {
  switch (format) {
    case raster::ImageFormat::jpeg:
      return "jpg";
    case raster::ImageFormat::png:
      return "png";
    case raster::ImageFormat::webp:
      return "webp";
  }
  return {};
}

io::Result<void> writeWholeFile(const fs::path& path, std::span<const std::byte> bytes) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.flush();
  if (file) return {};
  return io::fail(Code::ioError, "cannot be written; is there room?", path.string());
}

io::Result<std::unique_ptr<TileSet>> createMbtiles(const fs::path& path, const TileSetFacts& facts) {
  return Mbtiles::create(path, facts);
}

io::Result<std::unique_ptr<TileSet>> createTileFolder(const fs::path& path, const TileSetFacts& facts) {
  return std::unique_ptr<TileSet>(std::make_unique<TileFolder>(path, facts));
}

}  // namespace tellurion::pyramid
