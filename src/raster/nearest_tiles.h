#pragma once

#include <memory>
#include <unordered_map>

#include "raster/tile_source.h"

namespace tellurion::raster {

/// A source's tiles for the time that something is made of several of them: none is loaded twice. One thread only; the
/// source must outlive it.
class NearestTiles {
 public:
  explicit NearestTiles(const TileSource& source) : source_(source), tiling_(source.info().scheme) {}

  using Tile = std::shared_ptr<const SourceTile>;
  struct Found {
    Tile tile;  ///< null: none
    int level = -1;
  };
  /// The deepest over `id`, itself included. Fails when the source does.
  io::Result<Found> find(const tiling::TileId& id);

 private:
  io::Result<Tile> at(const tiling::TileId& id);

  const TileSource& source_;
  tiling::Tiling tiling_;
  std::unordered_map<tiling::TileId, Tile, tiling::TileIdHash> tiles_;
};

}  // namespace tellurion::raster
