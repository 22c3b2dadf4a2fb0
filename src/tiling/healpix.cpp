#include <algorithm>
#include <cmath>

#include "tiling/octants.h"
#include "tiling/schemes.h"

// HEALPix (Gorski and others, 2005) in its own plane: `ring` counts from 0 at the north pole to 4 at the south pole
// (HEALPix's ring index divided by the number of pixels a side), `octants` is the longitude in units of 45 degrees. A
// root's square lies in it as a diamond: ring = ringOf(north corner) + u + v, octants = (middle) + (u - v), the last
// shrunk to a point towards a pole.
namespace tellurion::tiling::healpix {

namespace {

constexpr double kBorder = 2e-15;  // in u and v: nearer to a root's border than this is on it

double northCornerRing(int root) {
  return static_cast<double>(root / 4);
}
double middleOctants(int root) {
  return 2.0 * (root % 4) + (root / 4 == 1 ? 0.0 : 1.0);
}

struct PlanePoint {
  double ring;
  double octants;  // not yet within one turn
};

PlanePoint planeFromRoot(const RootPoint& p) {
  const double ring = northCornerRing(p.root) + (p.u + p.v);
  const double fromPole = std::min(ring, 4.0 - ring);
  double offset = p.u - p.v;
  if (fromPole < 1.0) offset = fromPole > 0.0 ? std::clamp(offset / fromPole, -1.0, 1.0) : 0.0;
  return {ring, middleOctants(p.root) + offset};
}

// [-1, 9] to [0, 8), exact.
double withinTurn(double octants) {
  if (octants < 0.0) return octants + 8.0;
  return octants >= 8.0 ? octants - 8.0 : octants;
}

struct Height {
  double sin;
  double cos;
};

// Of the latitude on a ring.
Height heightOf(double ring) {
  const double fromPole = std::min(ring, 4.0 - ring);
  if (fromPole < 1.0) {
    const double t = fromPole * fromPole / 3.0;  // 1 - |sin lat|
    return {ring < 2.0 ? 1.0 - t : t - 1.0, std::sqrt(t * (2.0 - t))};
  }
  const double s = (2.0 - ring) * (2.0 / 3.0);
  return {s, std::sqrt((1.0 - s) * (1.0 + s))};
}

double latRadians(double ring) {
  const Height h = heightOf(ring);
  return std::atan2(h.sin, h.cos);
}

// In a cap each root is a quarter turn of longitude.
RootPoint capRootPoint(double fromPole, double octants, bool north) {
  const double turn = octants < 0.0 ? octants + 8.0 : octants;
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

RootPoint beltRootPoint(double ring, double octants) {
  const double turn = octants < 0.0 ? octants + 8.0 : octants;
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

geo::Direction direction(const RootPoint& p) {
  const PlanePoint plane = planeFromRoot(p);
  const Height lat = heightOf(plane.ring);
  const geo::SinCos lon = sinCosOctants(withinTurn(plane.octants));
  return {geo::Vec3(lat.cos * lon.cos + 0.0, lat.cos * lon.sin + 0.0, lat.sin + 0.0)};
}

RootPoint rootPoint(const geo::Direction& d) {
  const double octants = octantsOf(d.n.y, d.n.x);
  const double z = std::fabs(d.n.z);
  if (!(std::isfinite(octants) && std::isfinite(z))) return {0, std::nan(""), std::nan("")};
  const double fromPole = std::sqrt(3.0 * (d.n.x * d.n.x + d.n.y * d.n.y) / (1.0 + z));
  if (fromPole < 1.0) return capRootPoint(fromPole, octants, d.n.z > 0.0);
  return beltRootPoint(std::clamp(2.0 - 1.5 * d.n.z, 1.0, 3.0), octants);
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
