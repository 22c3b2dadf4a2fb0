#pragma once

#include <optional>
#include <vector>

#include "geo/ellipsoid.h"
#include "raster/tile.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// The ground of an elevation tile, gutter included, with its slope between the samples. Columns and rows count samples
/// from 0 at the tile's upper left one and go from -0.5 to cells + 0.5: half a sample beyond the edge it says, to the
/// rounding, what the tile beyond it says. Immutable.
class HeightBlock {
 public:
  HeightBlock(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
              Raster<float> heights);

  int cells() const { return heights_.width - 1 - 2 * kGutter; }
  /// By bilinearHeight's rules.
  std::optional<double> height_m(double column, double row) const;
  /// How the ground rises, metres a metre: a vector along the ellipsoid in the body frame, towards higher ground. That
  /// of each cell in its middle, where it is the mean of the cell's opposite sides; bilinear between the middles.
  /// Nothing where the cell that the place lies in lacks a height.
  std::optional<geo::Vec3> gradient(double column, double row) const;

 private:
  Raster<float> heights_;
  Raster<geo::Vec3> gradients_;  ///< of each cell, gutter included; NaN where a corner lacks its height
};

/// The part of a tile's heights that one below it covers, gutter included: bilinear, by bilinearHeight's rules.
Raster<float> enlargedHeights(const Raster<float>& heights, const tiling::TileId& id, const tiling::TileId& below);

}  // namespace tellurion::raster
