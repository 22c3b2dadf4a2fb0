#pragma once

#include "raster/raster.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// How many levels below a tile its surface is compared with directly; what is deeper counts with the errors of the
/// last of them (triangle inequality). Every tile is read by this many ancestors.
inline constexpr int kComparedLevels = 3;

/// The largest vertical distance in metres between a tile's surface, bilinear between its samples (gutter included in
/// both rasters), and a descendant's. Both are bilinear on nested grids, so it is reached at one of the descendant's
/// samples: exact. In a cell of the tile where not all corners have data, the weights are shared among those that have;
/// where none has but the descendant does, the distance counts as `missing_m`.
double distanceToDescendant(const tiling::TileId& id, const raster::Raster<float>& samples, const tiling::TileId& below,
                            const raster::Raster<float>& samplesBelow, double missing_m);

/// The smallest float that is no less.
float roundedUp(double value);

}  // namespace tellurion::pyramid
