#include <algorithm>
#include <cmath>

#include "tiling/healpix_plane.h"

namespace tellurion::tiling::healpix {

namespace {

double latRadians(double ring) {
  const Height h = heightOf(ring);
  return std::atan2(h.sin, h.cos);
}

// In a cap each root is a quarter turn of longitude.
RootPoint capRootPoint(double fromPole, double turn, bool north) {
  int quarter = std::min(static_cast<int>(turn * 0.5), 3);
  double across = std::clamp(turn - 2.0 * quarter - 1.0, -1.0, 1.0);
  if (quarter > 0 && across <= -1.0 + kBorder) {
    --quarter;
    across = 1.0;
  } else if (quarter == 3 && across >= 1.0 - kBorder) {
    quarter = 0;
    across = -1.0;
  }
  const double right = fromPole * (1.0 + across) / 2.0;
  const double left = fromPole * (1.0 - across) / 2.0;
  return north ? RootPoint{quarter, right, left} : RootPoint{8 + quarter, 1.0 - left, 1.0 - right};
}

// Between the caps the plane is cut by two families of parallel lines: a diamond is a column i of one and j of the
// other.
struct Diamond {
  int i;
  int j;
};
int rootOf(const Diamond& d) {
  const int row = d.i + d.j;  // 0 north, 1 equatorial, 2 south
  if (row < 0 || row > 2) return kRoots;
  return 4 * row + ((row == 2 ? d.i - 1 : d.i) & 3);
}

RootPoint beltRootPoint(double ring, double turn) {
  const double a = (ring + turn - 1.0) / 2.0;
  const double b = (ring - turn + 1.0) / 2.0;  // a - i = u, b - j = v
  const int i = static_cast<int>(std::floor(a));
  const int j = static_cast<int>(std::floor(b));
  RootPoint best{kRoots, 0.0, 0.0};
  for (int di = -1; di <= 1; ++di) {
    for (int dj = -1; dj <= 1; ++dj) {
      const double u = a - (i + di);
      const double v = b - (j + dj);
      if (u < -kBorder || u > 1.0 + kBorder || v < -kBorder || v > 1.0 + kBorder) continue;
      const int root = rootOf({i + di, j + dj});
      if (root < best.root) best = {root, std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0)};
    }
  }
  return best;
}

}  // namespace

std::span<const RootLinks> links() {
  static constexpr auto kLinks = [] {
    std::array<RootLinks, kRoots> table{};
    for (std::uint8_t n = 0; n < 4; ++n) {
      const auto east = static_cast<std::uint8_t>((n + 1) % 4);
      const auto west = static_cast<std::uint8_t>((n + 3) % 4);
      const auto in = [](int row, int column) { return static_cast<std::uint8_t>(4 * row + column); };
      table[n] = {{{east, Edge::left, false},
                   {in(1, east), Edge::left, false},
                   {in(1, n), Edge::top, false},
                   {west, Edge::top, false}}};
      table[in(1, n)] = {{{n, Edge::bottom, false},
                          {in(2, n), Edge::left, false},
                          {in(2, west), Edge::top, false},
                          {west, Edge::right, false}}};
      table[in(2, n)] = {{{in(1, east), Edge::bottom, false},
                          {in(2, east), Edge::bottom, false},
                          {in(2, west), Edge::right, false},
                          {in(1, n), Edge::right, false}}};
    }
    return table;
  }();
  return kLinks;
}

RootPoint rootPointOnBorder(const PlaceOnPlane& place) {
  if (!(std::isfinite(place.turn) && std::isfinite(place.fromPole))) return {0, std::nan(""), std::nan("")};
  if (place.fromPole < 1.0) return capRootPoint(place.fromPole, place.turn, place.z > 0.0);
  return beltRootPoint(beltRing(place), place.turn);
}

geo::Direction direction(const RootPoint& p) {
  return directionInline(p);
}

RootPoint rootPoint(const geo::Direction& d) {
  const PlaceOnPlane place = placeOnPlane(d);
  const InsideRoot found = rootPointInside(place);
  return found.isInside() ? found.point() : rootPointOnBorder(place);
}

// Latitude depends on u + v only and longitude grows with u and falls with v, so a tile's extremes lie at its corners.
geo::GeoRect bounds(const TileId& id) {
  const Square q = squareOf(id);
  const double west = planeFromRoot({id.root, q.u0, q.v1}).octants * kRadiansPerOctant;
  const double east = planeFromRoot({id.root, q.u1, q.v0}).octants * kRadiansPerOctant;
  const double north = latRadians(planeFromRoot({id.root, q.u0, q.v0}).ring);
  const double south = latRadians(planeFromRoot({id.root, q.u1, q.v1}).ring);
  return paddedBounds(south, north, west, east);
}

double area(const TileId& id) {
  const double size = tileSize(id.level);
  return geo::kPi / 3.0 * size * size;
}

Scale scale() {
  // The squared length of a step of u is (4/3) / m + (pi^2 / 48) (1 - t)^2 m in a cap, with m = 2 - fromPole^2 / 3 and
  // t in [-1, 1] across the root: both extremes lie at the pole (m = 2), along a root's border (t = 1) and across it (t
  // = -1).
  return {.smallest = std::sqrt(2.0 / 3.0), .largest = std::sqrt(2.0 / 3.0 + geo::kPi * geo::kPi / 6.0)};
}

}  // namespace tellurion::tiling::healpix
