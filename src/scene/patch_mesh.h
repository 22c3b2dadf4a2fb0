#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "scene/frame.h"

namespace tellurion::scene {

/// A mesh, or that quarter of it over a child of its tile.
struct MeshPart {
  static constexpr int kWhole = -1;
  const TerrainMesh* mesh = nullptr;  ///< not null
  int quadrant = kWhole;
};

/// Along an edge of a patch lies one of a finer tile, which is drawn with its coarse edge there, or is a part itself.
struct FinerEdge {
  MeshPart finer;
  std::uint8_t finerEdge = 0;  ///< tiling::Edge
  std::uint8_t edge = 0;       ///< likewise, of the patch
  /// Where the beginning of the finer edge and its end lie along the patch's, 0..1, dyadic.
  double from = 0.0;
  double to = 1.0;
};

/// What is drawn for a while where no tile's own mesh fits: of `base`, which leaves its edges as `coarseEdges` says
/// (bit e, of a whole mesh), with what finer tiles have along its edges as vertices too, so that no crack is left. All
/// of it is interior. A part has the places of its child, and is its own surface whatever the morph: it starts nowhere
/// else. For ground that is nested (CutOptions::isNested); a finer tile's vertices there hold all that `base` has. Pure
/// but for the serial. Of more vertices than 16 bits can number, those of finer tiles that come last are left out.
std::shared_ptr<const TerrainMesh> patchMesh(const MeshPart& base, std::uint8_t coarseEdges,
                                             std::span<const FinerEdge> finer, double vertexGrid_m);

}  // namespace tellurion::scene
