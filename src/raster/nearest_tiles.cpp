#include "raster/nearest_tiles.h"

#include <algorithm>
#include <utility>

namespace tellurion::raster {

io::Result<NearestTiles::Found> NearestTiles::find(const tiling::TileId& id) {
  for (int level = std::min<int>(id.level, source_.info().maxLevel); level >= 0; --level) {
    auto tile = at(id.ancestor(level));
    if (!tile) return tl::unexpected(std::move(tile.error()));
    if (*tile) return Found{.tile = std::move(*tile), .level = level};
  }
  return Found{};
}

io::Result<NearestTiles::Tile> NearestTiles::at(const tiling::TileId& id) {
  const auto known = tiles_.find(id);
  if (known != tiles_.end()) return known->second;
  const auto presence = source_.presence(id);
  const bool mayBe = presence ? presence->stored : source_.info().bounds.intersects(tiling_.bounds(id));
  Tile tile;
  if (mayBe) {
    auto loaded = source_.load(id);
    if (!loaded) return tl::unexpected(std::move(loaded.error()));
    if (*loaded) tile = std::make_shared<const SourceTile>(std::move(**loaded));
  }
  return tiles_.emplace(id, std::move(tile)).first->second;
}

}  // namespace tellurion::raster
