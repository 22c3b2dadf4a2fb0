#include <algorithm>
#include <cmath>

#include "tiling/octants.h"
#include "tiling/schemes.h"

namespace tellurion::tiling::geographic {

namespace {

// Longitude and latitude in octants. Root 0 holds the western hemisphere, root 1 the eastern.
double lonOctants(int root, double u) {
  return 4.0 * (u - (root == 0 ? 1.0 : 0.0));
}
double latOctants(double v) {
  return 2.0 - 4.0 * v;
}

}  // namespace

std::span<const RootLinks> links() {
  // Across a pole lies the other root at longitude + 180 degrees, which has the same u.
  static constexpr std::array<RootLinks, kRoots> kLinks{
      {{{{1, Edge::top, false}, {1, Edge::left, false}, {1, Edge::bottom, false}, {1, Edge::right, false}}},
       {{{0, Edge::top, false}, {0, Edge::left, false}, {0, Edge::bottom, false}, {0, Edge::right, false}}}}};
  return kLinks;
}

geo::Direction direction(const RootPoint& p) {
  const double octants = lonOctants(p.root, p.u);
  const geo::SinCos lon = sinCosOctants(octants == -4.0 ? 4.0 : octants);
  const geo::SinCos lat = sinCosOctants(latOctants(p.v));
  return {geo::Vec3(lat.cos * lon.cos + 0.0, lat.cos * lon.sin + 0.0, lat.sin)};
}

RootPoint rootPoint(const geo::Direction& d) {
  const double lon = octantsOf(d.n.y, d.n.x) / 4.0;
  const double lat = std::atan2(d.n.z, std::sqrt(d.n.x * d.n.x + d.n.y * d.n.y)) / kRadiansPerOctant;
  const double v = std::clamp(0.5 - lat / 4.0, 0.0, 1.0);
  if (lon >= 1.0) return {0, 0.0, v};
  if (lon > 0.0) return {1, lon, v};
  return {0, std::max(lon + 1.0, 0.0), v};
}

geo::GeoRect bounds(const TileId& id) {
  const Square q = squareOf(id);
  return {.south = geo::Angle::radians(latOctants(q.v1) * kRadiansPerOctant),
          .north = geo::Angle::radians(latOctants(q.v0) * kRadiansPerOctant),
          .west = geo::Angle::radians(lonOctants(id.root, q.u0) * kRadiansPerOctant),
          .width = geo::Angle::radians(geo::kPi * (q.u1 - q.u0))};
}

double area(const TileId& id) {
  const Square q = squareOf(id);
  const double size = q.u1 - q.u0;
  const double middleLat = latOctants(0.5 * (q.v0 + q.v1));
  const double sinDifference = 2.0 * sinCosOctants(middleLat).cos * std::sin(geo::kPi / 2.0 * size);
  return geo::kPi * size * sinDifference;
}

Scale scale(int level) {
  // The shortest edge is the lower one of a tile at the pole; at level 0 both are of no length and the meridians
  // remain.
  const double shortest = level == 0 ? 1.0 : std::sin(geo::kPi * tileSize(level));
  return {.smallest = geo::kPi * std::min(1.0, shortest), .largest = geo::kPi};
}

}  // namespace tellurion::tiling::geographic
