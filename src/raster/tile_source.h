#pragma once

#include <optional>
#include <string>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

struct TileSourceInfo {
  std::string name;  ///< for messages: a path or a URL
  Kind kind = Kind::elevation;
  tiling::Scheme scheme = tiling::Scheme::cube;
  geo::Body body = geo::earth();
  int tileCells = kElevationCells;  ///< cells (elevation) or pixels (imagery) a side
  int maxLevel = 0;                 ///< the deepest level that holds a tile
  geo::GeoRect bounds = geo::GeoRect::whole();
};

/// Where tiles come from: one interface for both kinds of samples. Thread-safe.
class TileSource {
 public:
  virtual ~TileSource() = default;
  virtual const TileSourceInfo& info() const = 0;
  /// Nothing: there is no such tile (not the same as one without data). May block on disk or network.
  virtual io::Result<std::optional<SourceTile>> load(const tiling::TileId& id) const = 0;
};

}  // namespace tellurion::raster
