#pragma once

#include <cstdint>
#include <vector>

#include "scene/frame.h"

namespace tellurion::scene {

/// The surface that a tile's parent draws (with fine edges), at the samples of the tile: what it morphs from.
struct ParentSurface {
  std::vector<geo::Vec3> positions;    ///< (cells + 1)^2, row-major, body coordinates
  std::vector<double> heights_m;       ///< likewise, above the ellipsoid, linear between the mesh's vertices
  std::vector<std::uint8_t> isVertex;  ///< likewise, whether the parent's mesh has a vertex there
};

/// The parent's quadrant is the tile. On the tile's edges, which are lines of the parent's mesh, the surface depends on
/// the mesh's vertices on that line alone and in an order of their own, so that tiles which share an edge find the same
/// bits. Pure.
ParentSurface parentSurface(const TerrainMesh& parent, double vertexGrid_m, int quadrant, int cells);

}  // namespace tellurion::scene
