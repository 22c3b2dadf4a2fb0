#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "geo/ellipsoid.h"
#include "scene/frame.h"
#include "scene/oriented_box.h"
#include "scene/surface_grid.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// The share of a level's mean sample spacing that a mesh may miss at a vertex that it leaves out.
inline constexpr double kMeshToleranceShare = 0.2;
/// Likewise on level 2 of HEALPix, whose tiles are the body's curvature more than its ground.
inline constexpr double kBentMeshToleranceShare = 0.28;

/// Metres; of the level alone, so that two tiles of a level always agree on what to keep (docs/selection.md).
double meshTolerance_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level, int cells);
/// Vertices lie on the grid of multiples of this in body coordinates: a power of two, 2^-15 m (30 micrometres) up to
/// bodies of the Earth's size, for giants the largest that is at most 2^-38 of the diameter. Single precision and a
/// 16-bit rest hold any vertex of any tile exactly (TerrainVertex).
double vertexGrid_m(const geo::Ellipsoid& ellipsoid);

struct MadeMesh {
  std::shared_ptr<const TerrainMesh> mesh;
  OrientedBox box;  ///< holds every sample of the tile and every triangle, morphed towards the parent's surface too
  /// The largest distance in space between the bilinear ground of the samples, displaced from the ellipsoid, and the
  /// drawn ground at the same (s, t), with fine edges. A coarse edge's strip may miss as much as the coarser neighbour
  /// does there.
  double error_m = 0.0;
};

/// Makes a tile's triangles by right-triangle bisection: a sample is a vertex when leaving it out would move the ground
/// there by more than the level's tolerance, or the parent's surface, which it has to take the place of unseen;
/// vertices of the parent are vertices. On the edges the vertices depend on the edge's samples alone (bisection in one
/// dimension, the middle always kept; across the parent's middle its vertices too), and on the coarse variant's on
/// every second of them with the parent level's tolerance: what a neighbour one level coarser has there. parent: the
/// mesh that the tile morphs from; null: it does not. regular: every sample is a vertex instead, and every second one
/// of a coarse edge (the comparison mode). Thread-safe, pure but for the serial.
MadeMesh makeTerrainMesh(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                         const TerrainMesh* parent = nullptr, bool regular = false);

/// A number that no other mesh or texture of the process has.
std::uint64_t nextSerial();

}  // namespace tellurion::scene
