#pragma once

#include <unordered_map>
#include <vector>

#include "geo/geo_rect.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

/// An image on the surface, as a tree of images needs it.
struct PlacedImage {
  geo::GeoRect bounds;
  tiling::Cap cap;       ///< holds the bounds
  int deepestLevel = 0;  ///< of tiles that it has detail for
};

/// A cap that holds a rectangle.
tiling::Cap capAround(const geo::GeoRect& rect);

/// Images of any size and place, found by the tile that they reach into. Each hangs at the tile that holds its middle,
/// of the level whose tiles are about its size. Every tile knows how far all that hangs at it or below reaches.
/// One thread only while images are inserted; afterwards immutable.
class ImageTree {
 public:
  explicit ImageTree(tiling::Scheme scheme) : tiling_(scheme) {}

  /// Numbers count from 0 in the order of insertion.
  void insert(const PlacedImage& image);
  std::size_t size() const { return images_.size(); }
  const PlacedImage& image(int number) const { return images_[static_cast<std::size_t>(number)]; }

  /// The images that may reach into a tile, with its gutter, of at least a size across. In any order.
  std::vector<int> touching(const tiling::TileId& id, geo::Angle leastSize) const;
  /// Whether an image that may reach into a tile has detail for a level.
  bool isTouched(const tiling::TileId& id, int level) const;

 private:
  struct Node {
    std::vector<int> images;
    geo::Angle reach;  ///< from the middle of the tile, of all images at it and below
    int deepestLevel = 0;
  };
  template <class Enter, class Visit>
  void walk(const tiling::TileId& id, const Enter& enter, const Visit& visit) const;

  tiling::Tiling tiling_;
  std::vector<PlacedImage> images_;
  std::unordered_map<tiling::TileId, Node, tiling::TileIdHash> nodes_;
};

}  // namespace tellurion::raster
