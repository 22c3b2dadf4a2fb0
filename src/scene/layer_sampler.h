#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "scene/ground_layers.h"

namespace tellurion::scene {

inline constexpr double kWildestHeight_m = 1e6;  ///< more is damage, not ground

/// Something for every place of a tile where other tiles touch it: edges by tiling::Edge, corners by tiling::kCorners,
/// of which corner k lies between edges k - 1 and k (both run clockwise from the top left).
template <class T>
struct Rim {
  std::array<T, 4> edges{};
  std::array<T, 4> corners{};
};

/// The tiles of the same level that touch a tile.
struct Touching {
  std::array<tiling::TileId, 4> edges;
  std::array<std::optional<tiling::TileId>, 4> corners;
};

Touching touching(const tiling::Tiling& tiling, const tiling::TileId& id);

/// Levels of stored data in a tile, and where others touch it: there the deepest level that all have.
class StoredLevels {
 public:
  template <class LevelOf>
  StoredLevels(const tiling::TileId& id, const Touching& others, int cells, const LevelOf& levelOf)
      : own_(levelOf(id)), cells_(cells) {
    if (own_ < 0) return;
    for (std::size_t e = 0; e < 4; ++e)
      rim_.edges[e] = std::min(own_, levelOf(others.edges[e]));
    for (std::size_t k = 0; k < 4; ++k) {
      rim_.corners[k] = std::min(rim_.edges[k], rim_.edges[(k + 3) % 4]);
      if (others.corners[k]) rim_.corners[k] = std::min(rim_.corners[k], levelOf(*others.corners[k]));
    }
  }

  int own() const { return own_; }
  /// Sample (col, row), -1..cells + 1.
  int at(int col, int row) const {
    const bool top = row == 0;
    const bool bottom = row == cells_;
    const bool left = col == 0;
    const bool right = col == cells_;
    if (own_ < 0 || !(top || bottom || left || right)) return own_;
    if (top && left) return rim_.corners[0];
    if (top && right) return rim_.corners[1];
    if (bottom && right) return rim_.corners[2];
    if (bottom && left) return rim_.corners[3];
    return rim_.edges[top ? 0u : right ? 1u : bottom ? 2u : 3u];
  }
  /// Calls with each level that at() gives, at least once; -1: none.
  template <class Visit>
  void forEachLevel(const Visit& visit) const {
    visit(own_);
    if (own_ < 0) return;
    for (std::size_t k = 0; k < 4; ++k) {
      visit(rim_.edges[k]);
      visit(rim_.corners[k]);
    }
  }

 private:
  int own_;
  int cells_;
  Rim<int> rim_;
};

/// One elevation layer's samples of one tile, from whichever level they may come. One thread only; the layer, and the
/// seam if it has one, must outlive it.
class LayerSampler {
 public:
  LayerSampler(const GroundLayers::Layer& layer, const tiling::Tiling& tiling, const tiling::TileId& id,
               const Touching& others, int cells, const raster::Seam* seam);

  /// How much the layer counts there; 1 without a seam.
  double weightAt(int col, int row) const;
  const raster::Seam* seam() const { return seam_; }

  const raster::SourceTile* ownTile() const { return own_ == id_.level ? tile_.get() : nullptr; }
  int level() const { return own_; }

  /// Sample (col, row), -1..cells + 1. Blocks while the source does that does not tell what it stores.
  float at(int col, int row);

 private:
  LayerTiles::TilePointer fetch(int& level) const;
  const LayerTiles::TilePointer& coarser(int level);
  float sample(const raster::SourceTile& tile, int level, int col, int row) const;

  LayerTiles& tiles_;
  tiling::Tiling tiling_;
  const raster::Seam* seam_;  ///< null: none
  tiling::TileId id_;
  int cells_;
  StoredLevels levels_;
  int own_;  ///< level of tile_, which may be less than what is stored when that cannot be read
  LayerTiles::TilePointer tile_;
  int coarserLevel_ = -2;
  LayerTiles::TilePointer coarser_;
};

}  // namespace tellurion::scene
