#include "truth/drawn_triangles.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "scene/drawn_vertex.h"

namespace tellurion::truth {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// Along a unit direction from the origin (Moeller and Trumbore 1997).
double distanceTo(const geo::Vec3& a, const geo::Vec3& b, const geo::Vec3& c, const geo::Vec3& direction) {
  const geo::Vec3 ab = b - a;
  const geo::Vec3 ac = c - a;
  const geo::Vec3 p = geo::cross(direction, ac);
  const double determinant = geo::dot(ab, p);
  if (determinant == 0.0) return kNone;
  const double u = geo::dot(-a, p) / determinant;
  const geo::Vec3 q = geo::cross(-a, ab);
  const double v = geo::dot(direction, q) / determinant;
  if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0)) return kNone;
  const double along = geo::dot(ac, q) / determinant;
  return along > 0.0 ? along : kNone;
}

}  // namespace

double drawnAlong(const scene::Frame& frame, const geo::Ray& ray) {
  double nearest = kNone;
  std::vector<geo::Vec3> places;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const scene::TerrainMesh& mesh = *tile.mesh;
    places.clear();
    for (const scene::TerrainVertex& vertex : mesh.vertices)
      places.push_back(scene::drawnPosition(tile, vertex, frame) - ray.origin);
    const auto look = [&](const scene::IndexRange& range) {
      for (std::uint32_t i = range.first; i < range.first + range.count; i += 3)
        nearest = std::min(nearest, distanceTo(places[mesh.indices[i]], places[mesh.indices[i + 1]],
                                               places[mesh.indices[i + 2]], ray.direction));
    };
    look(mesh.interior);
    for (std::size_t e = 0; e < 4; ++e)
      look((tile.coarseEdges >> e & 1u) != 0 ? mesh.coarseEdge[e] : mesh.fineEdge[e]);
  }
  return nearest;
}

}  // namespace tellurion::truth
