#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scene/frame.h"
#include "scene/layer_tiles.h"

namespace tellurion::scene {

/// What a layer shows on a tile.
struct LayerPicture {
  std::shared_ptr<const TextureImage> image;  ///< the tile's own or an ancestor's; null: the layer has nothing here
  int level = 0;                              ///< of the tile that it belongs to
  bool isOwn = false;                         ///< it was made with this tile
  bool finerBelow = false;                    ///< the layer has tiles of its own among the children
};

/// Makes the pictures of tiles, one for each imagery layer, bottom first. How they are shown together is decided when
/// they are drawn (LayerLook). Thread-safe; blocks while sources do.
class ColourLayers {
 public:
  struct Layer {
    /// Its data sets: at each sample the finest that has data counts, of equally fine ones the later. None: it does not
    /// take part yet.
    std::vector<std::shared_ptr<LayerTiles>> sets;
    int pixels = raster::kImageryPixels;  ///< a side of a tile, without gutter, of all its data sets
    bool nightLights = false;             ///< pictures are black, their coverage the strength of the lights
  };
  /// compress: pictures are compressed in blocks (TextureImage::blocks).
  explicit ColourLayers(std::vector<Layer> layers, bool compress = false)
      : layers_(std::move(layers)), compress_(compress) {}

  /// Where a layer has no tile of its own, it is the picture of the parent, whose pictures are given (none: a root).
  std::vector<LayerPicture> pictures(const tiling::TileId& id, std::span<const LayerPicture> parent) const;
  /// What pictures() may load of sources that tell what they store. Never blocks.
  void addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const;
  std::size_t count() const { return layers_.size(); }
  int pixels(std::size_t layer) const { return layers_[layer].pixels; }

 private:
  std::vector<Layer> layers_;
  bool compress_ = false;
};

}  // namespace tellurion::scene
