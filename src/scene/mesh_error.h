#pragma once

#include "scene/bisection.h"
#include "scene/surface_grid.h"

namespace tellurion::scene {

/// Where a sample of a tile lies, body coordinates.
inline geo::Vec3 pointAt(const SurfaceGrid& grid, GridPoint p) {
  return grid.positions[grid.index(p.col, p.row)].m;
}

/// MadeMesh::error_m of a tile's triangles, the fine edges' among them: measured at every sample and every crossing of
/// a triangle's side with a line of samples, with what bilinear ground between four samples may differ from triangles,
/// and the curvature of a cell, on top. Pure.
double meshError_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                   const Triangulation& triangles);

}  // namespace tellurion::scene
