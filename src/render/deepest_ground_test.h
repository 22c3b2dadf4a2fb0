#pragma once

// How low a frame's triangles reach, for the tests of holes. Test code only.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "geo/ellipsoid.h"
#include "scene/drawn_vertex.h"
#include "scene/frame.h"

namespace tellurion::render {

/// The distance from the origin to the nearest point of a side.
inline double nearestOfSide(const geo::Vec3& a, const geo::Vec3& b) {
  const geo::Vec3 side = b - a;
  const double length2 = geo::dot(side, side);
  const double share = length2 > 0.0 ? std::clamp(-geo::dot(a, side) / length2, 0.0, 1.0) : 0.0;
  return geo::length(a + side * share);
}

/// Likewise of a triangle.
inline double nearestOfTriangle(const std::array<geo::Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const geo::Vec3 normal = geo::cross(b - a, c - a);
  const auto isLeftOf = [&](const geo::Vec3& from, const geo::Vec3& to) {
    return geo::dot(geo::cross(to - from, -from), normal) >= 0.0;
  };
  const bool isInside = geo::dot(normal, normal) > 0.0 && isLeftOf(a, b) && isLeftOf(b, c) && isLeftOf(c, a);
  if (isInside) return std::abs(geo::dot(normal, a)) / geo::length(normal);
  return std::min({nearestOfSide(a, b), nearestOfSide(b, c), nearestOfSide(c, a)});
}

/// Metres, >= 0: the ellipsoid lowered by this lies wholly below what the frame draws.
inline double deepestGround_m(const scene::Frame& frame, const geo::Ellipsoid& ellipsoid) {
  const double a = ellipsoid.semiMajorAxis_m();
  const geo::Vec3 unit(1.0 / a, 1.0 / a, 1.0 / ellipsoid.semiMinorAxis_m());  // the ellipsoid becomes the unit sphere
  double nearest = 1.0;
  std::vector<geo::Vec3> places;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const scene::TerrainMesh& mesh = *tile.mesh;
    places.clear();
    for (const scene::TerrainVertex& vertex : mesh.vertices)
      places.push_back(scene::drawnPosition(tile, vertex, frame).m * unit);
    const auto look = [&](const scene::IndexRange& range) {
      for (std::uint32_t i = range.first; i < range.first + range.count; i += 3)
        nearest = std::min(nearest, nearestOfTriangle({places[mesh.indices[i]], places[mesh.indices[i + 1]],
                                                       places[mesh.indices[i + 2]]}));
    };
    look(mesh.interior);
    for (std::size_t e = 0; e < 4; ++e)
      look((tile.coarseEdges >> e & 1u) != 0 ? mesh.coarseEdge[e] : mesh.fineEdge[e]);
  }
  return (1.0 - nearest) * a;
}

}  // namespace tellurion::render
