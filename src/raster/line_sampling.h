#pragma once

#include <span>

#include "raster/pixel_store.h"
#include "raster/raster.h"
#include "raster/tile_lines.h"

namespace tellurion::raster {

/// As bilinearHeights and bilinearColours (raster/sampling.h), to the last bit, of samples whose pixels lie on lines:
/// what a column or a row has in common is found once. `indices`: into the tile's samples, of rows that are lines,
/// ascending. False: a read failed.
bool bilinearHeightsOnLines(PixelStore<float>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                            std::span<float> out);
bool bilinearColoursOnLines(PixelStore<Rgba8>& store, const PixelLines& lines, std::span<const std::size_t> indices,
                            std::span<Rgba8> out);

}  // namespace tellurion::raster
