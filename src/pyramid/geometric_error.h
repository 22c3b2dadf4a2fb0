#pragma once

#include "raster/raster.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// How many levels below a tile its surface is compared with directly; what is deeper counts with the errors of the
/// last of them (triangle inequality). Every tile is read by this many ancestors.
inline constexpr int kComparedLevels = 3;

/// Metres that a comparison needs besides heights.
struct ErrorScale {
  double spacing_m = 0.0;  ///< the longest between two samples of the tile that is compared
  double missing_m = 0.0;  ///< what data far from any sample of that tile count as
};

/// The largest distance in metres between a tile's surface, bilinear between its samples (gutter included in both
/// rasters), and the samples of a descendant. Where all corners of the tile's cell have data it is the vertical
/// distance: both surfaces are bilinear on nested grids, so it is reached at one of the descendant's samples, exactly.
/// Where a corner has none, whatever fills the gap passes through the samples around that have data, and through all
/// heights between theirs: then it is a bound of the distance in space to those.
double distanceToDescendant(const tiling::TileId& id, const raster::Raster<float>& samples, const tiling::TileId& below,
                            const raster::Raster<float>& samplesBelow, const ErrorScale& scale);

/// The smallest float that is no less.
float roundedUp(double value);

}  // namespace tellurion::pyramid
