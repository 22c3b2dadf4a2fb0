#pragma once

#include <cstdint>
#include <memory>

#include "raster/image_grid.h"
#include "raster/tile_source.h"

namespace tellurion::raster {

struct GridTileOptions {
  std::uint64_t memoryBytes = std::uint64_t{128}
                              << 20;  ///< decoded images that are kept, least recently used goes first
  int tileCells = 0;                  ///< 0: the usual for the kind
};

/// Tiles of a tiling out of the images of a server, by RasterFile's sampling rules (docs/online.md). A tile is stored
/// where the service's bounds reach and its parent's samples are coarser than the finest pixels there; roots always
/// are. load() gives nothing where all that the server has shows in the parent already, also for a tile that presence()
/// calls stored: what the server has not is known only once it was asked. It fails when an image can never come or is
/// damaged, and when it was not prepared and the server is in trouble for a minute. Heights' errors are estimates
/// (estimatedStatistics). Thread-safe.
///
/// Fails when the service's levels make no sense or its plane is not known.
io::Result<std::shared_ptr<const TileSource>> gridTileSource(GridService service, tiling::Scheme scheme,
                                                             const std::shared_ptr<io::Resources>& resources,
                                                             const GridTileOptions& options = {});

}  // namespace tellurion::raster
