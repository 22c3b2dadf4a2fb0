#pragma once

#include <span>

#include "raster/pixel_store.h"
#include "raster/raster.h"

/// The resampling rules of RasterFile, at pixel coordinates. Each writes out[i] only where there is data, and returns
/// false when a read has failed (the store knows why).
namespace tellurion::raster {

bool bilinearHeights(PixelStore<float>& store, const PixelPlaces& places, std::span<float> out);
bool meanHeights(PixelStore<float>& store, const PixelPlaces& places, std::span<float> out);
bool bilinearColours(PixelStore<Rgba8>& store, const PixelPlaces& places, std::span<Rgba8> out);
bool meanColours(PixelStore<Rgba8>& store, const PixelPlaces& places, std::span<Rgba8> out);

}  // namespace tellurion::raster
