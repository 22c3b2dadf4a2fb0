#include "pyramid/terrain_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "pyramid/export_place.h"

namespace tellurion::pyramid {
namespace {

/// Tiles of a rectangle of columns and rows, rows from the south.
struct Block {
  std::int64_t startX = 0;
  std::int64_t endX = 0;
  std::int64_t startY = 0;
  std::int64_t endY = 0;
};

/// (row, column) of tiles as rectangles: runs of a row, joined with equal runs of the row before.
std::vector<Block> blocksOf(std::vector<std::pair<std::int64_t, std::int64_t>> tiles) {
  std::ranges::sort(tiles);
  std::vector<Block> done;
  std::vector<Block> open;  // end in the row before
  std::vector<Block> row;
  const auto closeRow = [&] {
    for (Block& run : row) {
      const auto above = std::ranges::find_if(open, [&](const Block& b) {
        return b.startX == run.startX && b.endX == run.endX && b.endY + 1 == run.startY;
      });
      if (above == open.end()) continue;
      run.startY = above->startY;
      open.erase(above);
    }
    done.insert(done.end(), open.begin(), open.end());
    open = std::exchange(row, {});
  };
  for (const auto& [y, x] : tiles) {
    if (!row.empty() && row.back().endY != y) closeRow();
    if (!row.empty() && row.back().endX + 1 == x) {
      row.back().endX = x;
    } else {
      row.push_back({.startX = x, .endX = x, .startY = y, .endY = y});
    }
  }
  closeRow();
  closeRow();
  return done;
}

class TerrainFolder final : public TileSet {
 public:
  TerrainFolder(std::filesystem::path path, TileSetFacts facts)
      : path_(std::move(path)), facts_(std::move(facts)), written_(static_cast<std::size_t>(facts_.maxZoom) + 1) {}

  io::Result<void> put(const MapTile& tile, std::span<const std::byte> bytes) override {
    const std::int64_t y = mapRows(MapScheme::geodetic, tile.zoom) - 1 - tile.y;
    written_[static_cast<std::size_t>(tile.zoom)].emplace_back(y, tile.x);
    return writeWholeFile(path_ / fmt::format("{}/{}/{}.terrain", tile.zoom, tile.x, y), bytes);
  }

  io::Result<void> finish() override {
    std::string available;
    for (auto& zoom : written_) {
      std::string blocks;
      for (const Block& b : blocksOf(std::move(zoom))) {
        blocks += fmt::format("{}{{\"startX\": {}, \"startY\": {}, \"endX\": {}, \"endY\": {}}}",
                              blocks.empty() ? "" : ", ", b.startX, b.startY, b.endX, b.endY);
      }
      available += fmt::format("{}\n    [{}]", available.empty() ? "" : ",", blocks);
    }
    const std::string text = fmt::format(
        "{{\n  \"generator\": \"{}\",\n  \"tilejson\": \"2.1.0\",\n  \"format\": \"quantized-mesh-1.0\",\n  "
        "\"version\": \"1.0.0\",\n"
        "  \"scheme\": \"tms\",\n  \"projection\": \"EPSG:4326\",\n  \"tiles\": [\"{{z}}/{{x}}/{{y}}.terrain\"],\n"
        "  \"bounds\": [{}],\n  \"minzoom\": 0,\n  \"maxzoom\": {},\n  \"available\": [{}\n  ]\n}}\n",
        kGenerator, boundsText(facts_), facts_.maxZoom, available);
    return writeWholeFile(path_ / kLayerJsonName, std::as_bytes(std::span(text)));
  }

 private:
  std::filesystem::path path_;
  TileSetFacts facts_;
  std::vector<std::vector<std::pair<std::int64_t, std::int64_t>>> written_;  ///< (row, column) of each zoom
};

}  // namespace

io::Result<std::unique_ptr<TileSet>> createTerrainFolder(const std::filesystem::path& path, const TileSetFacts& facts) {
  return std::unique_ptr<TileSet>(std::make_unique<TerrainFolder>(path, facts));
}

}  // namespace tellurion::pyramid
