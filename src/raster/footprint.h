#pragma once

#include <vector>

#include "geo/geo_rect.h"
#include "raster/placement.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// The part of a body that a raster covers. Immutable, a value.
class Footprint {
 public:
  explicit Footprint(const Placement& placement);

  /// Holds every pixel's full area.
  const geo::GeoRect& bounds() const { return bounds_; }
  /// The largest, over a grid of places, of the smaller side of a pixel there.
  geo::Angle finestSpacing() const { return spacing_; }
  /// False only when no place of the tile is in the raster or as near to it as `within`.
  bool mayTouch(const tiling::Tiling& tiling, const tiling::TileId& id, geo::Angle within = {}) const;

 private:
  void measureSpacing(const Placement& placement);
  void findBounds(const Placement& placement);
  void findPatches(const Placement& placement);

  geo::GeoRect bounds_ = geo::GeoRect::whole();
  geo::Angle spacing_;
  std::vector<tiling::Cap> patches_;  ///< together they hold the raster; empty: it may be anywhere
};

}  // namespace tellurion::raster
