#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "pyramid/base_layer.h"
#include "pyramid/input_set.h"
#include "pyramid/memory_budget.h"
#include "pyramid/tile_walk.h"
#include "pyramid/void_fill.h"

namespace tellurion::pyramid {

/// A tile that is stored or about to be: its record, and what is in it where that is at hand without its payload, which
/// then may be empty.
struct KnownTile {
  TileRecord record;
  std::shared_ptr<const raster::Raster<float>> heights;
  std::shared_ptr<const raster::Raster<raster::Rgba8>> pixels;
};

/// A stored tile across an edge, seen from there.
struct AdjacentTile {
  KnownTile tile;
  tiling::Edge edge = tiling::Edge::top;  ///< its edge that is shared
  bool reversed = false;                  ///< it runs the other way
};

/// All that is needed to make a tile, read beforehand by the thread that owns the database or made just before. The
/// rest comes from the inputs.
struct TileTask {
  tiling::TileId id;
  std::vector<int> inputs;  ///< that may reach into the tile or its gutter
  std::array<std::optional<KnownTile>, 4> children;
  std::array<std::optional<raster::Raster<float>>, 4> childDepths;  ///< elevation: as TileDatabase::depths
  /// Elevation: the tiles of the children's level that touch an edge from outside, [edge][half], half 0 at the smaller
  /// s or t.
  std::array<std::array<std::optional<AdjacentTile>, 2>, 4> beyond;
  std::vector<KnownTile> deeper;  ///< elevation: tiles below the children, down to kComparedLevels
  bool hasChildren() const;
};

/// Tiles that were made together, children before their parents.
struct MadeTiles {
  std::vector<TileRecord> records;
  std::uint64_t candidates = 0;  ///< that were looked at for them
};

/// Makes tiles for one thread. Nothing: there is no data in the tile, and no child.
///
/// Elevation: a sample that a stored child has is the child's; others are the inputs at that place. Both are the same
/// number, because a sample is a function of its place alone; taking it from the child spares reading the inputs again.
/// The gutter of a tile of a block is sampled, for the tiles beside it may be of another block.
/// Imagery: a quadrant whose child is stored is the child halved in linear light; the rest is sampled from the inputs.
class TileMaker {
 public:
  TileMaker(const BuildPlan& plan, const BaseLayer* base, const MemoryBudget& budget)
      : plan_(plan),
        base_(base),
        inputs_(plan, budget.openFiles, budget.bytesPerFile),
        fill_(plan, base, inputs_, budget.lattices) {}
  io::Result<MadeTiles> make(const TileTask& task);
  /// A candidate of BuildPlan::blockLevel with all tiles below it, while what they hold is still in memory.
  io::Result<MadeTiles> makeBlock(const Candidate& candidate);
  const InputSet& inputs() const { return inputs_; }

 private:
  using Made = io::Result<std::optional<KnownTile>>;
  struct Family;

  Made makeTile(const TileTask& task);
  Made makeElevation(const TileTask& task);
  Made makeImagery(const TileTask& task);
  io::Result<std::optional<Family>> makeFamily(const Candidate& candidate, MadeTiles& made);
  io::Result<void> sampleOpenHeights(const TileTask& task, const std::vector<bool>& known,
                                     raster::Raster<float>& samples, raster::Raster<float>& depths);
  io::Result<void> sampleOpenColours(const TileTask& task, const std::vector<bool>& known,
                                     raster::Raster<raster::Rgba8>& pixels);

  const BuildPlan& plan_;
  const BaseLayer* base_;  ///< null: none
  InputSet inputs_;
  VoidFill fill_;
};

}  // namespace tellurion::pyramid
