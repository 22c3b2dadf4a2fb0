#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "pyramid/base_layer.h"
#include "pyramid/input_set.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {

/// Heights where data of different depths meet, with no step between them. One thread only.
///
/// Beside data of level d, in its voids and beyond its border, the coarser surface P is moved to meet it. Level by
/// level from the coarsest, P(L) = P(L-1) + the residuals (data - P(L-1)) at those samples of level L that have data of
/// level L or deeper, weighted by distance and fading to none over four samples of L. So what a level could not yet
/// match is left to the next one, over half the width: wide steps become wide slopes, and at the rim what is left is
/// what two samples of the data itself differ by. Where the topmost data at a place is itself of level L, P(L) is that.
/// Deeper data never moves, and where nothing coarser has data a void stays one.
///
/// A height is a function of its place alone: neither tiles, threads nor the order of asking matter, to the last bit.
/// It depends on data no farther away than FillPlan::reachDownTo says. (docs/decisions/0013-voids.md)
class VoidFill {
 public:
  /// Keeps so many tiles of finer data, of some 0.2 MB each.
  VoidFill(const BuildPlan& plan, const BaseLayer* base, InputSet& inputs, std::size_t mostLattices);
  ~VoidFill();

  struct Heights {
    std::vector<float> heights_m;     ///< NODATA where nothing has data
    std::vector<std::int8_t> depths;  ///< level of the data there, before it was moved; -1: none
  };
  /// Of samples of a tile, gutter included. `inputs`: those that may reach any of them, bottom first.
  io::Result<Heights> heights(const tiling::TileId& id, std::span<const int> inputs, const raster::OpenPlaces& samples);

 private:
  struct Lattice;
  struct Layers;
  struct Pair;
  using Lattices = std::vector<std::shared_ptr<Lattice>>;

  io::Result<Layers> layersAt(const tiling::TileId& id, std::span<const int> inputs, const raster::OpenPlaces& samples);
  /// P(to) at those of the layers' places that are named by index.
  io::Result<std::vector<double>> surface(const Layers& layers, std::span<const geo::Direction> places,
                                          std::span<const std::size_t> which, int to);
  io::Result<std::vector<double>> movedBy(int level, std::span<const geo::Direction> places);
  io::Result<void> makeResiduals(const std::vector<Pair>& pairs, const Lattices& lattices, int level);
  io::Result<Lattices> latticesNear(int level, std::span<const geo::Direction> places);
  io::Result<std::shared_ptr<Lattice>> lattice(const tiling::TileId& id);
  io::Result<std::shared_ptr<Lattice>> makeLattice(const tiling::TileId& id);

  const BuildPlan& plan_;
  const BaseLayer* base_;  ///< null: none
  InputSet& inputs_;
  std::size_t mostLattices_;
  struct Kept {
    std::shared_ptr<Lattice> lattice;
    std::uint64_t lastUse = 0;
  };
  std::unordered_map<tiling::TileId, Kept, tiling::TileIdHash> kept_;
  std::uint64_t uses_ = 0;
};

}  // namespace tellurion::pyramid
