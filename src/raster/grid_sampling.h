#pragma once

#include <functional>
#include <memory>

#include "raster/grid_places.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// The decoded image, or null where there is none. May block.
template <class T>
using GridImages = std::function<io::Result<std::shared_ptr<const Raster<T>>>(const GridImageId&)>;

template <class T>
struct GridSamples {
  Raster<T> samples;        ///< of a tile, gutter included; kNoData or coverage 0 where there is no data
  bool addsDetail = false;  ///< some sample inside the gutter is of pixels that are finer than the parent's samples
};

/// The samples of a tile out of the images of a grid, by RasterFile's rules. A sample whose square meets an image that
/// is missing is read on the next coarser level, as if there were no finer one. Fails as an image does.
io::Result<GridSamples<float>> sampleGrid(const GridGeometry& geometry, const tiling::Tiling& tiling,
                                          const tiling::TileId& id, int cells, const GridImages<float>& images);
io::Result<GridSamples<Rgba8>> sampleGrid(const GridGeometry& geometry, const tiling::Tiling& tiling,
                                          const tiling::TileId& id, int cells, const GridImages<Rgba8>& images);

}  // namespace tellurion::raster
