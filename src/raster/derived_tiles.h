#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "raster/height_colours.h"
#include "raster/tile_source.h"

namespace tellurion::raster {

/// Heights that pictures are made of.
struct DerivedHeights {
  std::shared_ptr<const TileSource> source;
  std::optional<double> seam_m = 0.0;  ///< to the sources before it, as Seam::of has it
};

/// Imagery made of heights, at the moment it is asked for. A pixel is as large as a cell of the elevation tiles that it
/// is made of, which lie that many levels deeper (two, with the usual sizes); where there are none so deep, of the
/// deepest there are. Heights of all sources are laid over each other, later ones over earlier ones where they have
/// data, with a seam where a local one ends; where none has, a pixel is transparent. A tile is stored where there are
/// heights for its own pixels; roots always are. What can be told ahead, and what is fetched ahead, is what the sources
/// tell and need. load() fails when theirs does. Thread-safe.
///
/// Sources: at least one, of kind elevation, one tiling, body and size of tiles, a power of two up to 256 cells; else
/// it fails.
io::Result<std::shared_ptr<const TileSource>> derivedTileSource(const std::vector<DerivedHeights>& heights,
                                                                HeightColours colours);

}  // namespace tellurion::raster
