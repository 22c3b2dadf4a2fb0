#pragma once

#include <memory>

#include "pyramid/pyramid_reader.h"

namespace tellurion::pyramid {

/// The database under an append, as a bottom layer: the samples of any tile, from the stored tile or else from its
/// nearest stored ancestor. Thread-safe.
class BaseLayer {
 public:
  explicit BaseLayer(std::shared_ptr<const PyramidReader> reader) : reader_(std::move(reader)) {}

  struct Ground {
    raster::Raster<float> heights;  ///< with gutter; NODATA where no ancestor is stored
    /// A sample each: the level of the data that it comes from; -1: none. Of filled voids that of what filled them.
    std::vector<std::int8_t> depths;
  };
  /// A function of the place alone: where a sample lies on a border, the finest of the stored tiles around decides, so
  /// that neighbours which ask agree to the last bit.
  io::Result<Ground> heights(const tiling::TileId& id) const;
  /// With gutter; no coverage where no ancestor is stored.
  io::Result<raster::Raster<raster::Rgba8>> colours(const tiling::TileId& id) const;

 private:
  struct Found;
  class Heights;
  io::Result<std::optional<Found>> nearest(const tiling::TileId& id) const;
  std::shared_ptr<const PyramidReader> reader_;
};

}  // namespace tellurion::pyramid
