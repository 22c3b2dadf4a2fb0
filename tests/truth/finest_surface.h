#pragma once

#include <unordered_map>
#include <vector>

#include "geo/ellipsoid.h"
#include "raster/tile_source.h"

// The other truth that pictures are measured against: the surface of the finest level (docs/selection.md), which no
// refinement makes better. Read from the tile database alone: no meshes, no levels of detail, no GPU.
namespace tellurion::truth {

/// The finest ground of an elevation source, held whole in memory: in each place bilinear between the samples of the
/// deepest tile that is stored there, laid off along the ellipsoid's normal. Samples on an edge or a corner where the
/// tiles that touch are not all stored lie between those of the level above. Immutable once made, thread-safe.
class FinestSurface {
 public:
  /// Throws std::runtime_error where a tile cannot be read or has gaps: tests end there.
  explicit FinestSurface(const raster::TileSource& source);

  /// Metres above the ellipsoid.
  double height_m(const geo::Direction& place) const;
  const geo::Ellipsoid& ellipsoid() const { return ellipsoid_; }
  /// Distance in metres from the origin, above the surface, to where a ray (unit direction) first meets it; NaN when it
  /// never does. Exact to three millionths of the distance: no feature is stepped over, for a block of cells is left
  /// only when its steepest slope shows that the ray stays above.
  double distanceAlong(const geo::Ray& ray) const;

 private:
  struct Tile {
    tiling::TileId id;
    std::uint8_t childMask = 0;
    raster::Raster<float> heights_m;  ///< (cells + 1)^2
  };
  /// A square of a tile's cells, at most kBlockCells a side where it has no children; else its quarters follow each
  /// other, each of the tile's own cells or a whole tile below.
  struct Node {
    geo::Vec3 low{};  ///< a box that holds its ground, body axes
    geo::Vec3 high{};
    double steepest = 0.0;  ///< no slope of its ground is steeper; blocks only
    int firstQuarter = -1;
    int tile = -1;
    // Where it lies on its root; blocks only.
    double u = 0.0;
    double v = 0.0;
    double size = 0.0;
  };
  struct Block {
    int tile = 0;
    int col = 0;
    int row = 0;
    int cells = 0;
  };
  struct Search;

  void read(const raster::TileSource& source, const tiling::TileId& id);
  int storedLevel(tiling::TileId id) const;
  void agreeWithNeighbours(Tile& tile) const;
  void fill(int node, const Block& block);
  void bound(Node& node, const Block& block) const;
  const Node& blockAt(const tiling::RootPoint& p) const;
  double heightIn(const Node& block, const tiling::RootPoint& p) const;
  double above(const geo::BodyPosition& p, const Node& near, geo::Direction& up) const;

  tiling::Tiling tiling_;
  geo::Ellipsoid ellipsoid_;
  int cells_;
  std::vector<Tile> tiles_;  ///< parents before children
  std::unordered_map<tiling::TileId, int, tiling::TileIdHash> tileOf_;
  std::vector<Node> nodes_;  ///< the roots first
};

}  // namespace tellurion::truth
