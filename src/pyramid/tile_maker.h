#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "pyramid/base_layer.h"
#include "pyramid/input_set.h"
#include "pyramid/void_fill.h"

namespace tellurion::pyramid {

/// A stored tile across an edge, seen from there.
struct AdjacentTile {
  TileRecord record;
  tiling::Edge edge = tiling::Edge::top;  ///< its edge that is shared
  bool reversed = false;                  ///< it runs the other way
};

/// All that is needed to make a tile, read beforehand by the thread that owns the database. The rest comes from the
/// inputs.
struct TileTask {
  tiling::TileId id;
  std::vector<int> inputs;                                          ///< that may reach into the tile or its gutter
  std::array<std::optional<TileRecord>, 4> children;                ///< that are stored
  std::array<std::optional<raster::Raster<float>>, 4> childDepths;  ///< elevation: as TileDatabase::depths
  /// Elevation: the tiles of the children's level that touch an edge from outside, [edge][half], half 0 at the smaller
  /// s or t.
  std::array<std::array<std::optional<AdjacentTile>, 2>, 4> beyond;
  std::vector<TileRecord> deeper;  ///< elevation: stored tiles below the children, down to kComparedLevels
  bool hasChildren() const;
};

/// A thread has no more inputs open at a time.
inline constexpr std::size_t kMostOpenFiles = 16;

/// What each open input of each thread may keep of decoded blocks, so that all together keep about 512 MiB; at least
/// 1 MiB, for a tile needs some at once.
std::size_t cacheBytesPerFile(int jobs, std::size_t inputs);

/// Makes tiles for one thread. Nothing: there is no data in the tile, and no child.
///
/// Elevation: a sample that a stored child has is the child's; others are the inputs at that place. Both are the same
/// number, because a sample is a function of its place alone; taking it from the child spares reading the inputs again.
/// Imagery: a quadrant whose child is stored is the child halved in linear light; the rest is sampled from the inputs.
class TileMaker {
 public:
  TileMaker(const BuildPlan& plan, const BaseLayer* base, std::size_t cacheBytes)
      : plan_(plan), base_(base), inputs_(plan, kMostOpenFiles, cacheBytes), fill_(plan, base, inputs_) {}
  io::Result<std::optional<TileRecord>> make(const TileTask& task);
  const InputSet& inputs() const { return inputs_; }

 private:
  io::Result<std::optional<TileRecord>> makeElevation(const TileTask& task);
  io::Result<std::optional<TileRecord>> makeImagery(const TileTask& task);
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
