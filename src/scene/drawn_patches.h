#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "scene/frame.h"
#include "scene/patch_mesh.h"
#include "scene/select.h"

namespace tellurion::scene {

/// Gives tiles of a frame that no mesh of their own fits, or that are not here, one that is made for them: out of what
/// is here, so that it needs no source and no worker (tens of microseconds a tile). Keeps what the next frame may have
/// too. One thread only.
class DrawnPatches {
 public:
  /// frame.tiles are those of the selection, in its order; the facts are TileRecords.
  void apply(const Selection& selection, const tiling::Tiling& tiling, Frame& frame);

 private:
  using Key = std::vector<std::uint64_t>;  ///< all that a patch is made of
  std::shared_ptr<const TerrainMesh> patch(const MeshPart& base, std::uint8_t coarseEdges,
                                           std::span<const FinerEdge> finer, double vertexGrid_m);

  std::map<Key, std::shared_ptr<const TerrainMesh>> last_;
  std::map<Key, std::shared_ptr<const TerrainMesh>> now_;
  // Kept for their memory: what stays from frame to frame allocates nothing.
  Key key_;
  std::vector<FinerEdge> finer_;
};

/// How the finer tile's edge lies along that of a coarser one, or an equal one, which is across it.
FinerEdge finerEdgeAlong(const tiling::Tiling& tiling, const tiling::TileId& coarse, const tiling::TileId& fine,
                         std::uint8_t edge);

}  // namespace tellurion::scene
