#pragma once

#include <memory>
#include <span>
#include <vector>

#include "scene/current_step.h"
#include "scene/frame.h"
#include "scene/layer_tiles.h"

namespace tellurion::scene {

/// What a layer shows on a tile.
struct LayerPicture {
  std::shared_ptr<const TextureImage> image;  ///< the tile's own or an ancestor's; null: the layer has nothing here
  int level = 0;                              ///< of the tile that it belongs to
  bool isOwn = false;                         ///< it was made with this tile
  bool finerBelow = false;                    ///< the layer has tiles of its own among the children
  std::uint64_t edition = 0;                  ///< CurrentStep's, of a layer that follows the clock; of others 0
};

/// Makes the pictures of tiles, one for each imagery layer, bottom first. How they are shown together is decided when
/// they are drawn (LayerLook). Thread-safe; blocks while sources do.
class ColourLayers {
 public:
  struct Layer {
    /// Its data sets: at each sample the finest that has data counts, of equally fine ones the later. None: it does not
    /// take part yet.
    std::vector<std::shared_ptr<LayerTiles>> sets;
    /// What roots of a set show until theirs is here: TileSource::overview, loadable without waiting. Of sets that have
    /// one.
    struct Overview {
      const LayerTiles* of = nullptr;
      std::shared_ptr<LayerTiles> tiles;
    };
    std::vector<Overview> overviews;
    int pixels = raster::kImageryPixels;  ///< a side of a tile, without gutter, of all its data sets
    bool isStrength = false;              ///< pictures are black, their coverage the strength of lights or water
    std::shared_ptr<CurrentStep> step;    ///< of a layer that follows the clock, in place of sets; else null
  };
  /// compress: pictures are compressed in blocks (TextureImage::blocks).
  explicit ColourLayers(std::vector<Layer> layers, bool compress = false)
      : layers_(std::move(layers)), compress_(compress) {}

  /// Where a layer has no tile of its own, it is the picture of the parent, whose pictures are given (none: a root).
  std::vector<LayerPicture> pictures(const tiling::TileId& id, std::span<const LayerPicture> parent) const;
  /// Of a root: its pictures, as far as they are here, else those of its overview. Blocks while sources do that do not
  /// tell what they store.
  std::vector<LayerPicture> standIns(const tiling::TileId& id) const;
  bool isBare() const;  ///< no layer takes part
  /// What pictures() may load of sources that tell what they store. Never blocks.
  void addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const;

  bool followsClock() const;
  /// CurrentStep's of each layer, 0 of those that do not follow the clock.
  std::vector<std::uint64_t> editions() const;
  /// Those of layers that follow the clock are of its time step.
  bool areUpToDate(std::span<const LayerPicture> pictures) const;
  /// Pictures of a tile, those of layers that follow the clock made anew where they are not of its time step. over: of
  /// each layer a picture over this one that it is drawn with where it has none of its own.
  std::vector<LayerPicture> renewed(const tiling::TileId& id, std::span<const LayerPicture> pictures,
                                    std::span<const LayerPicture> over) const;
  /// Of addNeeds() those of layers that follow the clock.
  void addNeedsOfSteps(const tiling::TileId& id, std::vector<TileNeed>& needs) const;
  /// The deepest level that a picture of a layer that follows the clock belongs to; -1: none.
  int levelOfSteps(std::span<const LayerPicture> pictures) const;

  std::size_t count() const { return layers_.size(); }
  int pixels(std::size_t layer) const { return layers_[layer].pixels; }

 private:
  std::vector<Layer> layers_;
  bool compress_ = false;
};

}  // namespace tellurion::scene
