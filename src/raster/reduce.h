#pragma once

#include "raster/raster.h"

namespace tellurion::raster {

/// Half the size, rounded down (a side of 1 stays 1): each pixel the mean of 2 x 2, in linear light, colour weighted
/// with coverage, coverage itself averaged. An odd last column or row is left out.
Raster<Rgba8> halved(const Raster<Rgba8>& image);

}  // namespace tellurion::raster
