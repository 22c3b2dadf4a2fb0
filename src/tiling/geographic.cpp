#include <algorithm>
#include <array>
#include <cmath>

#include "tiling/faces.h"
#include "tiling/octants.h"

// Longitude and latitude, folded (docs/decisions/0010-geographic-caps.md). Faces 0 to 3 are equirectangular between the
// parallels of 45 degrees. On a cap the square's concentric squares become parallels near its border and the pole lies
// in its middle as on a plane. Angles here are counted in octants of 45 degrees, so that the border is at colatitude 1.
namespace tellurion::tiling::geographic {

namespace {

constexpr double kBorder = 1e-15;  // in octants: nearer to a root's border than this is on it

struct Polar {
  double colatitude;
  double longitude;
};

// Within a quarter of a cap: m from the pole, 0, to the border, 1; t across, from -1 to 1. At the pole m sqrt(1 + t^2)
// and atan(t) are the place's polar coordinates, on the border m is the colatitude and t the longitude. Between the two
// the second's share is the square of the colatitude: about the pole the map is that of the plane to second order.
double squareness(double t) {
  return std::sqrt(1.0 + t * t);
}
// Solves c = m (g (1 - c^2) + c^2).
double colatitudeAt(double m, double t) {
  if (m == 1.0) return 1.0;
  const double g = squareness(t);
  return 2.0 * m * g / (1.0 + std::sqrt(1.0 + 4.0 * m * m * g * (g - 1.0)));
}
double distanceAt(double colatitude, double t) {  // the same, for m
  const double g = squareness(t);
  return colatitude / (g - colatitude * colatitude * (g - 1.0));
}
double longitudeAcross(double colatitude, double t) {
  const double share = colatitude * colatitude;
  return (1.0 - share) * (std::atan(t) / kRadiansPerOctant) + share * t;
}
double slopeAcross(double colatitude, double t) {
  const double share = colatitude * colatitude;
  return (1.0 - share) / (kRadiansPerOctant * (1.0 + t * t)) + share;
}
// The inverse of longitudeAcross, by Newton's method from within 0.02.
double acrossAt(double colatitude, double longitude) {
  constexpr int kSteps = 3;
  const double share = colatitude * colatitude;
  double t = (1.0 - share) * std::tan(longitude * kRadiansPerOctant) + share * longitude;
  for (int i = 0; i < kSteps; ++i)
    t -= (longitudeAcross(colatitude, t) - longitude) / slopeAcross(colatitude, t);
  return t;
}

// y of a cap's place, positive towards longitude 0.
double towardsGreenwich(int root, double y) {
  return root == kNorthFace ? y : -y;
}

Polar polarFromFace(int root, const FacePoint& p) {
  const double x = p.x;
  const double y = towardsGreenwich(root, p.y);
  const double m = std::max(std::fabs(x), std::fabs(y));
  if (m == 0.0) return {0.0, 0.0};
  const bool frontOrBack = std::fabs(y) >= std::fabs(x);
  const double t = frontOrBack ? x / y : -y / x;
  const double centre = frontOrBack ? (y > 0.0 ? 0.0 : 4.0) : (x > 0.0 ? 2.0 : -2.0);
  const double colatitude = colatitudeAt(m, t);
  return {colatitude, centre + longitudeAcross(colatitude, t)};
}

FacePoint faceFromPolar(int root, const Polar& polar) {
  const int quarter = static_cast<int>(std::lround(polar.longitude * 0.5));
  const double t = acrossAt(polar.colatitude, polar.longitude - 2.0 * quarter);
  const double m = distanceAt(polar.colatitude, t);
  switch (quarter & 3) {
    case 0:
      return {t * m, towardsGreenwich(root, m)};
    case 1:
      return {m, towardsGreenwich(root, -t * m)};
    case 2:
      return {-t * m, towardsGreenwich(root, -m)};
    default:
      return {-m, towardsGreenwich(root, t * m)};
  }
}

// One number for a meridian, whichever root it is reached through: (-4, 4].
double withinTurn(double longitude) {
  return longitude > 4.0 ? longitude - 8.0 : longitude;
}

/// Where a place is, exactly on roots 0 to 3.
struct Octants {
  double longitude;
  double latitude;
};
Octants inOctants(const RootPoint& p) {
  const FacePoint f = facePoint(p.u, p.v);
  if (p.root < kNorthFace) return {withinTurn(2.0 * p.root + f.x), -f.y};
  const Polar polar = polarFromFace(p.root, f);
  return {withinTurn(polar.longitude), p.root == kNorthFace ? 2.0 - polar.colatitude : polar.colatitude - 2.0};
}

double unitFromFace(double x) {
  return std::clamp(0.5 + 0.5 * x, 0.0, 1.0);
}

RootPoint sideRootPoint(double longitude, double latitude) {
  const int quarter = static_cast<int>(std::floor((longitude + 1.0) * 0.5));
  const double across = longitude - 2.0 * quarter;
  const double v = unitFromFace(-latitude);
  const int root = quarter & 3;
  const int before = (quarter + 3) & 3;
  const int after = (quarter + 1) & 3;
  if (across <= kBorder - 1.0 && before < root) return {before, 1.0, v};
  if (across >= 1.0 - kBorder && after < root) return {after, 0.0, v};
  return {root, unitFromFace(across), v};
}

// Gauss and Legendre's rule of twelve points on [0, 1].
template <class Function>
double integral(const Function& f) {
  struct Node {
    double offset;
    double weight;
  };
  static constexpr std::array<Node, 6> kNodes{{{0.1252334085114689, 0.2491470458134028},
                                               {0.3678314989981802, 0.2334925365383548},
                                               {0.5873179542866175, 0.2031674267230659},
                                               {0.7699026741943047, 0.1600783285433462},
                                               {0.9041172563704749, 0.1069393259953184},
                                               {0.9815606342467193, 0.0471753363865118}}};
  double sum = 0.0;
  for (const Node& n : kNodes)
    sum += 0.5 * n.weight * (f(0.5 - 0.5 * n.offset) + f(0.5 + 0.5 * n.offset));
  return sum;
}

// Steradians for a unit square of m and t * m.
double densityOnCap(double m, double t) {
  const double g = squareness(t);
  const double c = colatitudeAt(m, t);
  const double slopeAlong = (g - c * c * (g - 1.0)) / (1.0 + 2.0 * m * c * (g - 1.0));  // of c along m, t held
  return kRadiansPerOctant * kRadiansPerOctant * std::sin(c * kRadiansPerOctant) / m * slopeAlong * slopeAcross(c, t);
}

// A tile of a cap lies in one quarter, from m0 to m1 and, across, from a0 to a1; or a diagonal of the cap is its own
// and its halves are alike.
double areaInQuarter(double m0, double m1, double a0, double a1) {
  return (m1 - m0) * (a1 - a0) * integral([&](double i) {
           const double m = m0 + (m1 - m0) * i;
           return integral([&](double k) { return densityOnCap(m, (a0 + (a1 - a0) * k) / m); });
         });
}
double areaOnDiagonal(double m0, double m1) {
  return 2.0 * (m1 - m0) * integral([&](double i) {
           const double m = m0 + (m1 - m0) * i;
           const double width = (m1 - m0) * i;
           return width * integral([&](double k) { return densityOnCap(m, (m0 + width * k) / m); });
         });
}

double capArea(const Square& q) {
  if (q.u1 - q.u0 == 1.0) return 2.0 * geo::kPi * (1.0 - std::sqrt(0.5));
  const FacePoint a = facePoint(q.u0, q.v0);
  const FacePoint b = facePoint(q.u1, q.v1);
  const double x0 = std::fabs(nearestToZero(a.x, b.x));
  const double x1 = std::fabs(farthestFromZero(a.x, b.x));
  const double y0 = std::fabs(nearestToZero(a.y, b.y));
  const double y1 = std::fabs(farthestFromZero(a.y, b.y));
  if (x0 == y0) return areaOnDiagonal(x0, x1);
  return y0 > x0 ? areaInQuarter(y0, y1, x0, x1) : areaInQuarter(x0, x1, y0, y1);
}

double sideArea(const Square& q) {
  const double size = q.u1 - q.u0;
  const double middle = 1.0 - (q.v0 + q.v1);
  return geo::kPi / 2.0 * size * 2.0 * sinCosOctants(middle).cos * std::sin(kRadiansPerOctant * size);
}

}  // namespace

geo::Direction direction(const RootPoint& p) {
  const Octants at = inOctants(p);
  const geo::SinCos lon = sinCosOctants(at.longitude);
  const geo::SinCos lat = sinCosOctants(at.latitude);
  return {geo::Vec3(lat.cos * lon.cos + 0.0, lat.cos * lon.sin + 0.0, lat.sin + 0.0)};
}

LonLat lonLat(const RootPoint& p) {
  constexpr double kDegreesPerOctant = 45.0;
  const Octants at = inOctants(p);
  return {.longitude_degrees = at.longitude * kDegreesPerOctant + 0.0,
          .latitude_degrees = at.latitude * kDegreesPerOctant + 0.0};
}

RootPoint rootPoint(const geo::Direction& d) {
  const double longitude = octantsOf(d.n.y, d.n.x);
  if (!(std::isfinite(longitude) && std::isfinite(d.n.z))) return {0, std::nan(""), std::nan("")};
  const double fromAxis = std::sqrt(d.n.x * d.n.x + d.n.y * d.n.y);
  const double latitude = std::atan2(d.n.z, fromAxis) / kRadiansPerOctant;
  if (std::fabs(latitude) <= 1.0 + kBorder) return sideRootPoint(longitude, latitude);
  const int root = latitude > 0.0 ? kNorthFace : kNorthFace + 1;
  const FacePoint p = faceFromPolar(root, {std::atan2(fromAxis, std::fabs(d.n.z)) / kRadiansPerOctant, longitude});
  return {root, unitFromFace(p.x), unitFromFace(p.y)};
}

geo::GeoRect bounds(const TileId& id) {
  const Square q = squareOf(id);
  if (id.root < kNorthFace) {
    const FacePoint a = facePoint(q.u0, q.v0);
    const FacePoint b = facePoint(q.u1, q.v1);
    return paddedBounds(-b.y * kRadiansPerOctant, -a.y * kRadiansPerOctant, (2.0 * id.root + a.x) * kRadiansPerOctant,
                        (2.0 * id.root + b.x) * kRadiansPerOctant);
  }
  // Colatitudes are the same on both caps.
  static constexpr PolarFace kCap{
      .colatitude = [](const FacePoint& p) { return polarFromFace(kNorthFace, p).colatitude * kRadiansPerOctant; },
      .longitude = [](int root, const FacePoint& p) { return polarFromFace(root, p).longitude * kRadiansPerOctant; }};
  return polarFaceBounds(kCap, id.root, q);
}

double area(const TileId& id) {
  return id.root < kNorthFace ? sideArea(squareOf(id)) : capArea(squareOf(id));
}

Scale scale() {
  // Smallest along the parallels of 45 degrees, on both sides of them. At a pole, on the equator and along the
  // meridians of faces 0 to 3 it is that of the plane, and nowhere larger by more than 6.65e-6 (on a cap's diagonals
  // near its pole).
  return {.smallest = geo::kPi / 2.0 * std::sqrt(0.5), .largest = geo::kPi / 2.0 * (1.0 + 7e-6)};
}

}  // namespace tellurion::tiling::geographic
