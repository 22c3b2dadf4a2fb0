#pragma once

#include <memory>
#include <vector>

#include "scene/frame.h"
#include "scene/layer_tiles.h"

namespace tellurion::scene {

/// What the ground looks like where no layer covers it, sRGB.
inline constexpr raster::Rgba8 kPlainGround{150, 145, 138, 255};

/// The colours of one tile, composed of all imagery layers.
struct ComposedColour {
  std::shared_ptr<const TextureImage> image;  ///< null: no layer has a tile of its own here
  bool finerBelow = false;                    ///< a layer has tiles of its own among the children
};

/// Composes imagery layers, bottom first, in linear light. Thread-safe; blocks while sources do.
class ColourLayers {
 public:
  struct Layer {
    std::shared_ptr<LayerTiles> tiles;  ///< null: it does not take part
    double opacity = 1.0;
    bool nightLights = false;
  };
  /// pixels: a side of a tile of every layer, without gutter.
  ColourLayers(std::vector<Layer> layers, int pixels) : layers_(std::move(layers)), pixels_(pixels) {}

  /// Where a layer has no tile of its own but others do, its nearest ancestor's is enlarged.
  ComposedColour compose(const tiling::TileId& id) const;
  /// What compose() may load of sources that tell what they store. Never blocks.
  void addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const;
  int pixels() const { return pixels_; }
  bool empty() const { return layers_.empty(); }

 private:
  std::vector<Layer> layers_;
  int pixels_;
};

/// A texture with all its mip levels from its finest: rgb and a are reduced apart (a is the strength of night lights).
std::shared_ptr<const TextureImage> textureFrom(raster::Raster<raster::Rgba8> finest);

}  // namespace tellurion::scene
