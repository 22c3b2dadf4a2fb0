#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "raster/seam.h"
#include "scene/layer_tiles.h"
#include "scene/surface_grid.h"

namespace tellurion::scene {

/// Lowest and highest ground, metres above the ellipsoid.
struct HeightRange {
  double low_m = 0.0;
  double high_m = 0.0;
};

/// The ground of one tile, composed of all elevation layers.
struct ComposedGround {
  GroundSamples heights;                  ///< all finite, see GroundLayers for where no layer has data
  HeightRange range;                      ///< of this tile's ground and of all below it
  std::array<HeightRange, 4> childRange;  ///< the same of its children
  /// What this tile misses of the finest ground below, a distance in space: what the layers' sources say, and where a
  /// layer that has deeper tiles has gaps, two cells more. A gap between two samples that no coarser level shows is not
  /// known of.
  double error_m = 0.0;
  int level = -1;  ///< the deepest level at which a layer has samples of its own here; -1: no data
};

/// Composes elevation layers. Thread-safe; blocks while sources do.
///
/// The height of a vertex depends on its place and level only, whichever tile asks: where tiles that touch at an edge
/// or a corner are not all stored, the samples there are taken from the deepest level at which all are, so neighbours
/// agree bit for bit.
///
/// Down to the deepest level that any layer has stored, layers are laid over each other sample by sample. A sample
/// where none has data takes the mean of what has, next to it on its level; failing that it lies between what was
/// composed one level up, and so on up to level 0, where it has the height nearest to the ellipsoid that the layers
/// have anywhere. So a void is filled from its rim, and the ground beyond the border of data falls away over a distance
/// like the data's own size. The exception: of samples without data, those that the level above has too take the height
/// from there, data beside them or not, so that samples of parents are samples of their children also in voids. A point
/// of a coarse level's lattice that falls into a void thus has the mean of neighbours far away, and may stand some
/// hundred metres above or below the rim in wild mountains. A void over a coarser layer shows that layer, with a step
/// where they differ. Deeper than what is stored, the ground is bilinear between the samples composed there, so no
/// deeper level changes the surface.
///
/// Near its end a local layer counts less and less (raster::Seam), so that it does not stand as a cliff over those
/// below.
///
/// A layer may take part with some of its roots only, while the others are on their way: then it ends at their edges as
/// it would if it had no data beyond, and what is composed is whole all the same.
class GroundLayers {
 public:
  static constexpr std::uint32_t kAllRoots = ~std::uint32_t{0};
  struct Layer {
    std::shared_ptr<LayerTiles> tiles;
    /// Of the seam to the layers below, if the layer is local; 0: it ends with a step. Nothing:
    /// raster::Seam::kUsualShare.
    std::optional<double> seam_m = 0.0;
    std::uint32_t roots = kAllRoots;  ///< bit r: root r takes part

    Layer(std::shared_ptr<LayerTiles> of) : tiles(std::move(of)) {}  // NOLINT: a layer is its tiles
    Layer(std::shared_ptr<LayerTiles> of, std::optional<double> seam, std::uint32_t with = kAllRoots)
        : tiles(std::move(of)), seam_m(seam), roots(with) {}
    /// LayerTiles's, of the roots that take part.
    int storedLevel(const tiling::TileId& id) const {
      return ((roots >> id.root) & 1u) != 0 ? tiles->storedLevel(id) : -1;
    }
  };
  GroundLayers(tiling::Tiling tiling, std::vector<Layer> layers, int cells);

  /// parent: the composed heights of the tile over it, to save making them again; may be null.
  ComposedGround compose(const tiling::TileId& id, const GroundSamples* parent = nullptr) const;
  /// What compose() of a tile whose parent is given may load of sources that tell what they store; roots aside when it
  /// is the first: all of them. Never blocks.
  void addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const;
  int cells() const { return cells_; }
  bool isBare() const { return layers_.empty(); }  ///< there is none

 private:
  int storedLevel(const tiling::TileId& id) const;
  float farHeight_m() const;
  const raster::Seam* seamOf(std::size_t layer) const;

  tiling::Tiling tiling_;
  std::vector<Layer> layers_;
  std::vector<std::shared_ptr<raster::LateSeam>> seams_;  ///< a layer each
  int cells_;
  struct FarHeight {
    std::once_flag known;
    float height_m = 0.0f;
  };
  std::shared_ptr<FarHeight> far_ = std::make_shared<FarHeight>();
};

}  // namespace tellurion::scene
