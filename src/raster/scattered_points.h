#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geo/geo_rect.h"
#include "raster/packed_point.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// Points scattered over a body, of any density, found by place.
///
/// Local spacing. A cell of level g is dense when, of the 8 x 8 sub-cells of some square of four cells of level g that
/// it is one of, 16 hold a point: then points are about half a cell apart (spacingOf), or nearer. A point's spacing is
/// that of its deepest dense cell; one that has none is far from all others. So what counts is how evenly points cover
/// the ground: along a lone track, however near to each other, they make no dense cell.
///
/// Of a cell that holds more than kCrowded points of its own level, as tracks have, only the first of each eighth of a
/// spacing stays.
/// Immutable, thread-safe.
class ScatteredPoints {
 public:
  static constexpr int kNoLevel = -1;
  static constexpr std::size_t kCrowded = 64;
  static constexpr std::size_t kBytesEach = sizeof(PackedPoint) + 1;

  /// Takes them in any order, with the same result. Those of one cell of `mergeLevel`, or of one place, become one, at
  /// the mean of their places and heights.
  explicit ScatteredPoints(std::vector<PackedPoint> points, int mergeLevel = tiling::kMaxLevel);

  std::size_t size() const { return points_.size(); }
  const PackedPoint& point(std::size_t i) const { return points_[i]; }
  /// Level of its dense cell, 1 or deeper, or kNoLevel.
  int spacingLevel(std::size_t i) const { return levels_[i]; }
  /// Those that there are, coarsest first; without kNoLevel.
  const std::vector<int>& spacingLevels() const { return present_; }
  static geo::Angle spacingOf(int spacingLevel);
  /// Holds all points, but for a pole in their midst.
  const geo::GeoRect& area() const { return area_; }

  /// Some that follow each other: [first, last).
  struct Run {
    std::size_t first = 0;
    std::size_t last = 0;
    std::size_t size() const { return last - first; }
  };
  Run below(const tiling::TileId& cell, Run within) const;
  Run all() const { return {0, points_.size()}; }

  /// Runs, in order, that together hold all points no farther than `reach` from `cap`, and others; each of whole cells
  /// of `cellLevel`.
  std::vector<Run> near(const tiling::Cap& cap, geo::Angle reach, int cellLevel) const;
  /// Whether a point of the spacing may be so near; false only where none is.
  bool mayBeNear(int spacingLevel, const tiling::Cap& cap, geo::Angle reach) const;
  /// Cells of level `cellLevel`, or of the spacing's where that is less, that hold its points; in order.
  std::vector<tiling::TileId> cellsOf(int spacingLevel, int cellLevel) const;

 private:
  void merge(int mergeLevel);
  void findSpacings();
  bool markDense(int level);
  int occupied(const tiling::TileId& cell) const;
  void thinCrowded();
  void collectCells();
  void findArea();

  std::vector<PackedPoint> points_;  ///< by cell, then place
  std::vector<std::int8_t> levels_;
  std::vector<int> present_;
  std::vector<std::vector<std::uint64_t>> cells_;  ///< of each level that is present: its cells with such points
  geo::GeoRect area_;
};

}  // namespace tellurion::raster
