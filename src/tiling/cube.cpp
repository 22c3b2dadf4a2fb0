#include <algorithm>
#include <cmath>

#include "tiling/faces.h"
#include "tiling/octants.h"

namespace tellurion::tiling::cube {

namespace {

using geo::Vec3;

// A place on the plane that touches the unit sphere at a face's centre: x along u, y along v, both in [-1, 1].
struct PlanePoint {
  double x;
  double y;
};

// The equiangular mapping: tan(45 degrees * s), odd to the last bit and exact at the edges and the middle.
double planeFromFace(double s) {
  if (std::fabs(s) == 1.0) return s;
  return std::copysign(std::tan(kRadiansPerOctant * std::fabs(s)), s);
}
double planeFromUnit(double u) {
  return planeFromFace(2.0 * u - 1.0);
}

double unitFromPlane(double x) {
  if (std::fabs(x) >= 1.0) return x > 0.0 ? 1.0 : 0.0;
  return 0.5 + 0.5 * (std::atan(x) / kRadiansPerOctant);
}

// Seen from outside, x to the right and y down.
Vec3 bodyFromFace(int root, const PlanePoint& p) {
  switch (root) {
    case 0:
      return Vec3(1.0, p.x, -p.y);
    case 1:
      return Vec3(-p.x, 1.0, -p.y);
    case 2:
      return Vec3(-1.0, -p.x, -p.y);
    case 3:
      return Vec3(p.x, -1.0, -p.y);
    case kNorthFace:
      return Vec3(p.y, p.x, 1.0);
    default:
      return Vec3(-p.y, p.x, -1.0);
  }
}

PlanePoint faceFromBody(int root, const Vec3& n) {
  switch (root) {
    case 0:
      return {n.y / n.x, -n.z / n.x};
    case 1:
      return {-n.x / n.y, -n.z / n.y};
    case 2:
      return {n.y / n.x, n.z / n.x};
    case 3:
      return {-n.x / n.y, n.z / n.y};
    case kNorthFace:
      return {n.y / n.z, n.x / n.z};
    default:
      return {-n.y / n.z, n.x / n.z};
  }
}

// The lowest of the faces that a direction belongs to.
int faceOf(const Vec3& n) {
  const double x = std::fabs(n.x);
  const double y = std::fabs(n.y);
  const double z = std::fabs(n.z);
  const double largest = std::max({x, y, z});
  if (n.x == largest) return 0;
  if (n.y == largest) return 1;
  if (x == largest) return 2;
  if (y == largest) return 3;
  return n.z > 0.0 ? kNorthFace : kNorthFace + 1;
}

// On a face around the equator tan(lat) = -y cos(lon from the face's middle): largest and smallest where the longitude
// is nearest to or farthest from the middle.
geo::GeoRect equatorialBounds(int root, const Square& q) {
  const double west = (2.0 * q.u0 - 1.0) * kRadiansPerOctant;
  const double east = (2.0 * q.u1 - 1.0) * kRadiansPerOctant;
  const double cosMost = std::cos(nearestToZero(west, east));
  const double cosLeast = std::cos(farthestFromZero(west, east));
  const double top = -planeFromUnit(q.v0);
  const double bottom = -planeFromUnit(q.v1);
  const double middle = geo::kPi / 2.0 * root;
  return paddedBounds(std::atan(bottom * (bottom > 0.0 ? cosLeast : cosMost)),
                      std::atan(top * (top > 0.0 ? cosMost : cosLeast)), middle + west, middle + east);
}

constexpr PolarFace kPolarFace{
    .colatitude = [](const FacePoint& p) { return std::atan(std::hypot(planeFromFace(p.x), planeFromFace(p.y))); },
    .longitude =
        [](int root, const FacePoint& p) {
          const Vec3 n = bodyFromFace(root, {planeFromFace(p.x), planeFromFace(p.y)});
          return std::atan2(n.y, n.x);
        }};

// tan(b) - tan(a) without cancellation; a and b as face coordinates u.
double planeDifference(double a, double b) {
  const double difference = std::sin(2.0 * kRadiansPerOctant * (b - a));
  return difference / (std::cos(kRadiansPerOctant * (2.0 * a - 1.0)) * std::cos(kRadiansPerOctant * (2.0 * b - 1.0)));
}

// Solid angle of a plane triangle with twice the area `doubled`, seen from the sphere's centre (Van Oosterom and
// Strackee, 1983).
double solidAngle(const PlanePoint& p, const PlanePoint& q, const PlanePoint& r, double doubled) {
  const Vec3 a(p.x, p.y, 1.0);
  const Vec3 b(q.x, q.y, 1.0);
  const Vec3 c(r.x, r.y, 1.0);
  const double la = geo::length(a);
  const double lb = geo::length(b);
  const double lc = geo::length(c);
  return 2.0 * std::atan2(doubled, la * lb * lc + geo::dot(a, b) * lc + geo::dot(b, c) * la + geo::dot(c, a) * lb);
}

}  // namespace

geo::Direction direction(const RootPoint& p) {
  const Vec3 n = bodyFromFace(p.root, {planeFromUnit(p.u), planeFromUnit(p.v)});
  const double norm = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  return {Vec3(n.x / norm + 0.0, n.y / norm + 0.0, n.z / norm + 0.0)};
}

RootPoint rootPoint(const geo::Direction& d) {
  const int root = faceOf(d.n);
  const PlanePoint p = faceFromBody(root, d.n);
  return {root, unitFromPlane(p.x), unitFromPlane(p.y)};
}

geo::GeoRect bounds(const TileId& id) {
  return id.root < kNorthFace ? equatorialBounds(id.root, squareOf(id))
                              : polarFaceBounds(kPolarFace, id.root, squareOf(id));
}

double area(const TileId& id) {
  const Square q = squareOf(id);
  const PlanePoint a{planeFromUnit(q.u0), planeFromUnit(q.v0)};
  const PlanePoint b{planeFromUnit(q.u1), planeFromUnit(q.v0)};
  const PlanePoint c{planeFromUnit(q.u1), planeFromUnit(q.v1)};
  const PlanePoint d{planeFromUnit(q.u0), planeFromUnit(q.v1)};
  const double doubled = planeDifference(q.u0, q.u1) * planeDifference(q.v0, q.v1);
  return solidAngle(a, b, c, doubled) + solidAngle(a, c, d, doubled);
}

Scale scale() {
  // Along x the scale is (pi / 2) (1 + x^2) sqrt(1 + y^2) / (1 + x^2 + y^2): largest where y = 0, smallest at x = 0,
  // |y| = 1.
  return {.smallest = geo::kPi / 2.0 / std::sqrt(2.0), .largest = geo::kPi / 2.0};
}

}  // namespace tellurion::tiling::cube
