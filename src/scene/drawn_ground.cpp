#include "scene/drawn_ground.h"

#include <algorithm>
#include <array>

namespace tellurion::scene {
namespace {

/// A place of a tile in vertex units: 0..65535 over its side.
using TilePlace = geo::Vec2;

/// How far over a tile's edge, as a share of its side, a place on the edge may come out.
constexpr double kRounding = 1e-6;

std::optional<TilePlace> placeIn(const tiling::TileId& id, const tiling::RootPoint& p) {
  if (id.root != p.root) return std::nullopt;
  const double size = tiling::tileSize(id.level);
  const TilePlace place(p.u / size - id.x, p.v / size - id.y);
  const TilePlace inside(std::clamp(place.x, 0.0, 1.0), std::clamp(place.y, 0.0, 1.0));
  if (geo::length(place - inside) > kRounding) return std::nullopt;
  return inside * 65535.0;
}

TilePlace placeOf(const TerrainVertex& v) {
  return {v.s, v.t};
}

double crossed(const TilePlace& a, const TilePlace& b) {
  return a.x * b.y - a.y * b.x;
}

// The point over a place in a triangle, metres from the mesh's origin.
std::optional<geo::Vec3> pointIn(const std::array<const TerrainVertex*, 3>& corners, const TilePlace& place) {
  const TilePlace a = placeOf(*corners[0]), b = placeOf(*corners[1]), c = placeOf(*corners[2]);
  const double area = crossed(b - a, c - a);
  if (area == 0.0) return std::nullopt;
  const double wb = crossed(place - a, c - a) / area;
  const double wc = crossed(b - a, place - a) / area;
  constexpr double kSlack = -1e-9;
  if (std::min({wb, wc, 1.0 - wb - wc}) < kSlack) return std::nullopt;
  return geo::Vec3(corners[0]->position_tile) * (1.0 - wb - wc) + geo::Vec3(corners[1]->position_tile) * wb +
         geo::Vec3(corners[2]->position_tile) * wc;
}

std::optional<geo::Vec3> pointIn(const TerrainMesh& mesh, const IndexRange& range, const TilePlace& place) {
  for (std::uint32_t i = range.first; i + 2 < range.first + range.count; i += 3) {
    const std::array corners{&mesh.vertices[mesh.indices[i]], &mesh.vertices[mesh.indices[i + 1]],
                             &mesh.vertices[mesh.indices[i + 2]]};
    if (const auto point = pointIn(corners, place)) return point;
  }
  return std::nullopt;
}

std::optional<geo::Vec3> pointIn(const DrawnTile& tile, const TilePlace& place) {
  if (const auto point = pointIn(*tile.mesh, tile.mesh->interior, place)) return point;
  for (const tiling::Edge edge : tiling::kEdges) {
    const auto e = static_cast<std::size_t>(edge);
    const bool coarse = (tile.coarseEdges >> e & 1u) != 0;
    if (const auto point = pointIn(*tile.mesh, coarse ? tile.mesh->coarseEdge[e] : tile.mesh->fineEdge[e], place))
      return point;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> drawnHeight_m(const Frame& frame, const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                    const geo::Direction& place) {
  const tiling::RootPoint p = tiling.rootPoint(place);
  for (const DrawnTile& tile : frame.tiles) {
    const auto inTile = placeIn(tile.id, p);
    if (!inTile) continue;
    const auto point = pointIn(tile, *inTile);
    if (point) return ellipsoid.geodeticFromBody(tile.mesh->origin + *point).height_m;
  }
  return std::nullopt;
}

}  // namespace tellurion::scene
