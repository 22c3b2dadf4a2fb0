#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "geo/geo_rect.h"
#include "io/failure.h"
#include "raster/ground_block.h"
#include "raster/scattered_points.h"
#include "raster/shared_cache.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// The ground between scattered points: flat triangles, of their Delaunay triangulation on the sphere of directions, so
/// exact at the points.
///
/// A triangle is ground where the circle through its corners is no wider than kWidestCircle of the widest spacing among
/// them (ScatteredPoints): an alpha shape (Edelsbrunner, Kirkpatrick, Seidel 1983) whose alpha follows the points. So
/// no height is farther from a point than 2.4 of its spacings, and gaps and far points stay without data.
///
/// Found by level of spacing: each has the triangles whose widest spacing is of that level, and denser ones that share
/// a corner with one. For it, points that are denser by two levels and more are thinned to half its spacing. Where two
/// levels have ground the denser is exact.
///
/// Triangles are made where they are asked for, in blocks of some thousands of points with what lies around them as far
/// as it counts. A height depends on the points and its place alone, and there is no step where blocks meet.
/// Thread-safe.
class PointGround {
 public:
  static constexpr double kWidestCircle = 2.4;  ///< its radius, in spacings
  /// Keeps triangulated blocks up to so many bytes, besides the points.
  PointGround(ScatteredPoints points, std::uint64_t cacheBytes);

  const ScatteredPoints& points() const { return points_; }
  std::uint64_t cacheBytes() const { return cacheBytes_; }
  /// Holds the ground of a level of spacing.
  geo::GeoRect bounds(int spacingLevel) const;
  /// False only when no ground of the level is in the tile, its edges included, or as near to it as `within`.
  bool mayTouch(int spacingLevel, const tiling::Tiling& tiling, const tiling::TileId& id, geo::Angle within) const;
  /// Heights in metres, one for each place; out is written only where the level has ground.
  io::Result<void> sampleHeights(int spacingLevel, std::span<const geo::Direction> places, std::span<float> out) const;

  /// What a thread takes while it makes a block, at most.
  static constexpr std::uint64_t kBytesToMakeABlock = std::uint64_t{32} << 20u;

 private:
  struct BlockId {
    int spacingLevel;
    tiling::TileId cell;
    bool operator==(const BlockId&) const = default;
  };
  struct BlockIdHash {
    std::size_t operator()(const BlockId& id) const noexcept;
  };
  std::shared_ptr<const GroundBlock> makeBlock(const BlockId& id) const;

  ScatteredPoints points_;
  std::uint64_t cacheBytes_;
  mutable SharedCache<BlockId, GroundBlock, BlockIdHash> blocks_;
};

}  // namespace tellurion::raster
