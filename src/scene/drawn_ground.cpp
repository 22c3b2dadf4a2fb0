#include "scene/drawn_ground.h"

#include <algorithm>
#include <array>

#include "scene/drawn_vertex.h"

namespace tellurion::scene {
namespace {

/// A place of a tile in vertex units: 0..kPlaceUnits over its side.
using TilePlace = geo::Vec2;

/// How far over a tile's edge, as a share of its side, a place on the edge may come out.
constexpr double kRounding = 1e-6;

std::optional<TilePlace> placeIn(const tiling::TileId& id, const tiling::RootPoint& p) {
  if (id.root != p.root) return std::nullopt;
  const double size = tiling::tileSize(id.level);
  const TilePlace place(p.u / size - id.x, p.v / size - id.y);
  const TilePlace inside(std::clamp(place.x, 0.0, 1.0), std::clamp(place.y, 0.0, 1.0));
  if (geo::length(place - inside) > kRounding) return std::nullopt;
  return inside * static_cast<double>(kPlaceUnits);
}

TilePlace placeOf(const TerrainVertex& v) {
  return {v.s, v.t};
}

double crossed(const TilePlace& a, const TilePlace& b) {
  return a.x * b.y - a.y * b.x;
}

// The point over a place in a drawn triangle.
std::optional<geo::BodyPosition> pointIn(const Frame& frame, const DrawnTile& tile,
                                         const std::array<const TerrainVertex*, 3>& corners, const TilePlace& place) {
  const TilePlace a = placeOf(*corners[0]), b = placeOf(*corners[1]), c = placeOf(*corners[2]);
  const double area = crossed(b - a, c - a);
  if (area == 0.0) return std::nullopt;
  const double wb = crossed(place - a, c - a) / area;
  const double wc = crossed(b - a, place - a) / area;
  constexpr double kSlack = -1e-9;
  if (std::min({wb, wc, 1.0 - wb - wc}) < kSlack) return std::nullopt;
  const auto at = [&](std::size_t i) { return drawnPosition(tile, *corners[i], frame); };
  const geo::BodyPosition first = at(0);
  return first + ((at(1) - first) * wb + (at(2) - first) * wc);
}

std::optional<geo::BodyPosition> pointIn(const Frame& frame, const DrawnTile& tile, const IndexRange& range,
                                         const TilePlace& place) {
  const TerrainMesh& mesh = *tile.mesh;
  for (std::uint32_t i = range.first; i + 2 < range.first + range.count; i += 3) {
    const std::array corners{&mesh.vertices[mesh.indices[i]], &mesh.vertices[mesh.indices[i + 1]],
                             &mesh.vertices[mesh.indices[i + 2]]};
    if (const auto point = pointIn(frame, tile, corners, place)) return point;
  }
  return std::nullopt;
}

std::optional<geo::BodyPosition> pointIn(const Frame& frame, const DrawnTile& tile, const TilePlace& place) {
  if (const auto point = pointIn(frame, tile, tile.mesh->interior, place)) return point;
  for (const tiling::Edge edge : tiling::kEdges) {
    const auto e = static_cast<std::size_t>(edge);
    const bool coarse = (tile.coarseEdges >> e & 1u) != 0;
    const IndexRange& range = (coarse ? tile.mesh->coarseEdge : tile.mesh->fineEdge)[e];
    if (const auto point = pointIn(frame, tile, range, place)) return point;
  }
  return std::nullopt;
}

}  // namespace

std::optional<geo::BodyPosition> drawnPoint(const Frame& frame, const tiling::Tiling& tiling,
                                            const geo::Direction& place) {
  const tiling::RootPoint p = tiling.rootPoint(place);
  for (const DrawnTile& tile : frame.tiles) {
    const auto inTile = placeIn(tile.id, p);
    if (!inTile) continue;
    if (const auto point = pointIn(frame, tile, *inTile)) return point;
  }
  return std::nullopt;
}

std::optional<double> drawnHeight_m(const Frame& frame, const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                    const geo::Direction& place) {
  constexpr int kSteps = 8;
  constexpr double kNearEnough = 1e-9;  // 6 mm on Earth
  auto point = drawnPoint(frame, tiling, place);
  if (!point) return std::nullopt;
  // A chord's point stands beside its place: the place is looked for whose point is over the one that was asked.
  geo::Direction sought = place;
  for (int i = 0; i < kSteps; ++i) {
    const geo::Vec3 aside = place.n - ellipsoid.directionFromBody(*point).n;
    if (geo::length(aside) < kNearEnough) break;
    sought.n = geo::normalize(sought.n + aside);
    const auto next = drawnPoint(frame, tiling, sought);
    if (!next) break;
    point = next;
  }
  return ellipsoid.geodeticFromBody(*point).height_m;
}

}  // namespace tellurion::scene
