#include "raster/point_triangles.h"

#include <gdal_alg.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>

#include "raster/gdal_session.h"

namespace tellurion::raster {
namespace {

using Place = StereographicPlane::Place;

constexpr double kFarthestCosine = -0.97;
/// How far a place may be off the circle of three others, in sides, and still be taken to lie on it. Far above what
/// qhull confuses and planes round (1e-11), far below what distances of centimetres are told apart by.
constexpr double kOnCircle = 1e-8;
constexpr std::int32_t kNone = -1;

struct FreeTriangulation {
  void operator()(GDALTriangulation* t) const { GDALTriangulationFree(t); }
};

/// Twice the area; positive: counterclockwise.
double areaOf(const Place& a, const Place& b, const Place& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// A triangulation in which edges are turned.
class Mesh {
 public:
  Mesh(std::span<const geo::Direction> places, const std::vector<Place>& flat, std::vector<Triangle> triangles)
      : places_(places), flat_(flat), triangles_(std::move(triangles)) {
    join();
  }

  /// Until every edge between two triangles of one circle is the one that it has to be. Each turn makes the sum, over
  /// all edges, of their lower corner less, so it ends.
  void turnEdges() {
    std::vector<std::pair<std::int32_t, int>> open;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (int k = 0; k < 3; ++k)
        open.emplace_back(static_cast<std::int32_t>(t), k);
    }
    while (!open.empty()) {
      const auto [t, k] = open.back();
      open.pop_back();
      const std::int32_t other = neighbours_[static_cast<std::size_t>(t)][static_cast<std::size_t>(k)];
      if (other == kNone || !turned(t, k, other)) continue;
      for (int i = 0; i < 3; ++i) {
        open.emplace_back(t, i);
        open.emplace_back(other, i);
      }
    }
  }

  std::vector<Triangle> triangles() && { return std::move(triangles_); }

 private:
  using Neighbours = std::array<std::int32_t, 3>;  ///< [k] across the edge that is opposite corner k

  /// Finds the neighbours.
  void join() {
    struct Side {
      std::uint32_t low, high;
      std::int32_t triangle;
      int opposite;
    };
    std::vector<Side> sides;
    sides.reserve(triangles_.size() * 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax(triangles_[t][(k + 1) % 3], triangles_[t][(k + 2) % 3]);
        sides.push_back({low, high, static_cast<std::int32_t>(t), static_cast<int>(k)});
      }
    }
    std::ranges::sort(sides, {}, [](const Side& s) { return std::tuple(s.low, s.high, s.triangle); });
    neighbours_.assign(triangles_.size(), {kNone, kNone, kNone});
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const Side& a = sides[i - 1];
      const Side& b = sides[i];
      if (a.low != b.low || a.high != b.high) continue;
      neighbours_[static_cast<std::size_t>(a.triangle)][static_cast<std::size_t>(a.opposite)] = b.triangle;
      neighbours_[static_cast<std::size_t>(b.triangle)][static_cast<std::size_t>(b.opposite)] = a.triangle;
    }
  }

  /// By the places alone, in the order of their indices: the same bits in whatever mesh.
  bool lieOnACircle(std::array<std::uint32_t, 4> corners) const {
    std::ranges::sort(corners);
    const geo::Vec3& origin = places_[corners[0]].n;
    const geo::Vec3 a = places_[corners[1]].n - origin;
    const geo::Vec3 b = places_[corners[2]].n - origin;
    const geo::Vec3 c = places_[corners[3]].n - origin;
    // On a sphere, four on a circle are four in a plane.
    const double longest = std::max({geo::dot(a, a), geo::dot(b, b), geo::dot(c, c)});
    return std::abs(geo::dot(geo::cross(a, b), c)) <= kOnCircle * longest * longest;
  }

  /// Turns the edge between two triangles if it has to be; false: it stays.
  bool turned(std::int32_t first, int k, std::int32_t second) {
    Triangle& t = triangles_[static_cast<std::size_t>(first)];
    Triangle& u = triangles_[static_cast<std::size_t>(second)];
    Neighbours& ofT = neighbours_[static_cast<std::size_t>(first)];
    Neighbours& ofU = neighbours_[static_cast<std::size_t>(second)];
    const auto at = static_cast<std::size_t>(k);
    const auto across = static_cast<std::size_t>(std::ranges::find(ofU, first) - ofU.begin());
    if (across > 2) return false;
    const std::uint32_t p = t[at];
    const std::uint32_t q = t[(at + 1) % 3];
    const std::uint32_t r = t[(at + 2) % 3];
    const std::uint32_t s = u[across];
    if (u[(across + 1) % 3] != r || u[(across + 2) % 3] != q) return false;
    if (std::min(p, s) > std::min(q, r) || !lieOnACircle({p, q, r, s})) return false;
    if (!(areaOf(flat_[p], flat_[q], flat_[s]) > 0.0) || !(areaOf(flat_[p], flat_[s], flat_[r]) > 0.0)) return false;
    const std::int32_t besideQs = ofU[(across + 1) % 3];
    const std::int32_t besideSr = ofU[(across + 2) % 3];
    const std::int32_t besideRp = ofT[(at + 1) % 3];
    const std::int32_t besidePq = ofT[(at + 2) % 3];
    t = {p, q, s};
    ofT = {besideQs, second, besidePq};
    u = {p, s, r};
    ofU = {besideSr, besideRp, first};
    replaceNeighbour(besideQs, second, first);
    replaceNeighbour(besideRp, first, second);
    return true;
  }

  void replaceNeighbour(std::int32_t of, std::int32_t former, std::int32_t now) {
    if (of != kNone) std::ranges::replace(neighbours_[static_cast<std::size_t>(of)], former, now);
  }

  std::span<const geo::Direction> places_;
  const std::vector<Place>& flat_;
  std::vector<Triangle> triangles_;
  std::vector<Neighbours> neighbours_;
};

}  // namespace

StereographicPlane::StereographicPlane(const geo::Direction& centre, double unit) : centre_(centre.n), unit_(unit) {
  const geo::Vec3 aside = std::abs(centre_.z) < 0.9 ? geo::Vec3(0.0, 0.0, 1.0) : geo::Vec3(1.0, 0.0, 0.0);
  east_ = geo::normalize(geo::cross(aside, centre_));
  north_ = geo::cross(centre_, east_);
}

bool StereographicPlane::holds(const geo::Direction& place) const {
  return geo::dot(place.n, centre_) > kFarthestCosine;
}

Place StereographicPlane::at(const geo::Direction& place) const {
  // Away from the centre first: what is subtracted from each other then is small.
  const geo::Vec3 away = place.n - centre_;
  const double scale = 2.0 / ((1.0 + geo::dot(place.n, centre_)) * unit_);
  return {geo::dot(away, east_) * scale, geo::dot(away, north_) * scale};
}

StereographicPlane::Box StereographicPlane::boxAround(std::span<const geo::Direction> corners) const {
  Box box{HUGE_VAL, HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (const geo::Direction& corner : corners) {
    const Place place = at(corner);
    box = {std::min(box.minX, place.x), std::min(box.minY, place.y), std::max(box.maxX, place.x),
           std::max(box.maxY, place.y)};
  }
  const double side = std::hypot(box.maxX - box.minX, box.maxY - box.minY);
  const double arc = side * side * unit_ / 12.0 + side * 1e-9;
  return {box.minX - arc, box.minY - arc, box.maxX + arc, box.maxY + arc};
}

namespace {

/// qhull would say so on the standard error.
bool lieOnALine(const std::vector<Place>& flat) {
  constexpr double kStraight = 1e-10;
  const auto distance = [](const Place& a, const Place& b) { return std::hypot(b.x - a.x, b.y - a.y); };
  const Place& first = flat.front();
  const Place& last = *std::ranges::max_element(flat, {}, [&](const Place& p) { return distance(first, p); });
  const double length = distance(first, last);
  return std::ranges::all_of(
      flat, [&](const Place& p) { return std::abs(areaOf(first, last, p)) <= kStraight * length * length; });
}

}  // namespace

std::vector<Triangle> delaunayTriangles(std::span<const geo::Direction> places, const StereographicPlane& plane) {
  if (places.size() < 3) return {};
  std::vector<Place> flat(places.size());
  std::ranges::transform(places, flat.begin(), [&](const geo::Direction& place) { return plane.at(place); });
  if (lieOnALine(flat)) return {};
  std::vector<double> x(flat.size());
  std::vector<double> y(flat.size());
  std::ranges::transform(flat, x.begin(), &Place::x);
  std::ranges::transform(flat, y.begin(), &Place::y);
  const GdalMessages quiet;
  const std::unique_ptr<GDALTriangulation, FreeTriangulation> made(
      GDALTriangulationCreateDelaunay(static_cast<int>(x.size()), x.data(), y.data()));
  if (!made) return {};
  std::vector<Triangle> triangles;
  triangles.reserve(static_cast<std::size_t>(made->nFacets));
  for (const GDALTriFacet& facet : std::span(made->pasFacets, static_cast<std::size_t>(made->nFacets))) {
    const auto corner = [&](int k) { return static_cast<std::uint32_t>(facet.anVertexIdx[k]); };
    Triangle t{corner(0), corner(1), corner(2)};
    const double area = areaOf(flat[t[0]], flat[t[1]], flat[t[2]]);
    if (area == 0.0) continue;
    if (area < 0.0) std::swap(t[1], t[2]);
    triangles.push_back(t);
  }
  Mesh mesh(places, flat, std::move(triangles));
  mesh.turnEdges();
  return std::move(mesh).triangles();
}

}  // namespace tellurion::raster
