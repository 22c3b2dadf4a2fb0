#include "geo/ellipsoid.h"

#include <algorithm>
#include <cmath>

namespace tellurion::geo {

namespace {

// The way back from the body frame works in long double: where that is wider than a double (x86 Linux), closed form and
// all, its own error stays below the rounding of what goes in and out.
using Wide = long double;

// A place in the meridian plane of a point, with what its normal needs.
struct Meridian {
  Wide cosLat;
  Wide sinLat;
  Wide height_m;
  Wide fromAxis_m;
};

// Root of Vermeille's cubic (2011, sections 2 and 3), in the variables that Karney uses ("Geodesics on an ellipsoid of
// revolution", 2011, appendix B), with p = (R / a)^2, q = (1 - e^2) (Z / a)^2: u such that the quartic of the foot
// point splits.
Wide resolventRoot(Wide p, Wide q, Wide e4) {
  const Wide r = (p + q - e4) / 6;
  const Wide s = e4 * p * q / 4;
  const Wide r3 = r * r * r;
  const Wide discriminant = s * (2 * r3 + s);
  if (discriminant < 0) {  // inside the evolute, where r < 0: of three real roots the lowest
    const Wide angle = std::atan2(std::sqrt(-discriminant), -(s + r3));
    return r + 2 * r * std::cos(angle / 3);
  }
  const Wide root = std::sqrt(discriminant);
  const Wide t = std::cbrt(s + r3 < 0 ? s + r3 - root : s + r3 + root);
  return r + t + (t == 0 ? 0 : r * r / t);
}

// The foot of the perpendicular: kappa > 0 with cos(lat) : sin(lat) = R / (kappa + e^2) : Z / kappa.
Wide kappaOf(Wide p, Wide q, Wide e2) {
  const Wide e4 = e2 * e2;
  const Wide u = resolventRoot(p, q, e4);
  const Wide v = std::sqrt(u * u + e4 * q);
  const Wide uv = u < 0 ? e4 * q / (v - u) : u + v;
  const Wide w = std::max(Wide{0}, e2 * (uv - q) / (2 * v));
  return uv / (std::sqrt(uv + w * w) + w);
}

// In the equatorial plane, nearer to the axis than the evolute's cusp, two places are equally near; the northern is
// taken.
Meridian onSingularDisc(Wide r, Wide e2, Wide oneMinusF) {
  const Wide ratio = r / e2;
  return {.cosLat = ratio, .sinLat = std::sqrt((1 - ratio) * (1 + ratio)) / oneMinusF, .height_m = 0, .fromAxis_m = 0};
}

Meridian unnormalized(Wide r, Wide z, Wide flattening) {
  const Wide e2 = flattening * (2 - flattening);
  const Wide oneMinusF = 1 - flattening;
  if (e2 == 0) return {.cosLat = r, .sinLat = (r == 0 && z == 0) ? 1 : z, .height_m = 0, .fromAxis_m = 0};
  if (z == 0 && r < e2) return onSingularDisc(r, e2, oneMinusF);
  const Wide scaledZ = oneMinusF * z;
  const Wide kappa = kappaOf(r * r, scaledZ * scaledZ, e2);
  if (kappa == 0) return {.cosLat = r, .sinLat = z, .height_m = 0, .fromAxis_m = 0};
  return {.cosLat = r * (kappa / (kappa + e2)), .sinLat = z, .height_m = 0, .fromAxis_m = 0};
}

Meridian meridianOf(const BodyPosition& body, Wide a, Wide flattening) {
  const auto x = static_cast<Wide>(body.m.x);
  const auto y = static_cast<Wide>(body.m.y);
  const auto z = static_cast<Wide>(body.m.z);
  const Wide fromAxis = std::sqrt(x * x + y * y);
  Meridian m = unnormalized(fromAxis / a, z / a, flattening);
  const Wide norm = std::sqrt(m.cosLat * m.cosLat + m.sinLat * m.sinLat);
  m.cosLat /= norm;
  m.sinLat /= norm;
  const Wide axialSin = (1 - flattening) * m.sinLat;
  const Wide supportDistance = a * std::sqrt(m.cosLat * m.cosLat + axialSin * axialSin);
  m.height_m = fromAxis * m.cosLat + z * m.sinLat - supportDistance;
  m.fromAxis_m = fromAxis;
  return m;
}

// A ray or segment where the ellipsoid is the unit sphere.
Vec3 scaledToUnit(const Vec3& v, double equatorial, double polar) {
  return Vec3(v.x / equatorial, v.y / equatorial, v.z / polar);
}

}  // namespace

BodyPosition Ellipsoid::bodyFromGeodetic(const Geodetic& g) const {
  return bodyFromDirection(directionFromLatLon(g.lat, g.lon), g.height_m);
}

BodyPosition Ellipsoid::bodyFromDirection(const Direction& d, double height_m) const {
  const Vec3& n = d.n;
  const double axisRatio2 = (1.0 - f_) * (1.0 - f_);
  const double primeVertical_m = a_ / std::sqrt(n.x * n.x + n.y * n.y + axisRatio2 * n.z * n.z);
  const double equatorial = primeVertical_m + height_m;
  return {Vec3(n.x * equatorial, n.y * equatorial, n.z * (axisRatio2 * primeVertical_m + height_m))};
}

Geodetic Ellipsoid::geodeticFromBody(const BodyPosition& p) const {
  const Meridian m = meridianOf(p, static_cast<Wide>(a_), static_cast<Wide>(f_));
  const double lon = m.fromAxis_m == 0 ? 0.0 : std::atan2(p.m.y + 0.0, p.m.x);
  return {.lat = Angle::radians(static_cast<double>(std::atan2(m.sinLat, m.cosLat))),
          .lon = Angle::radians(lon),
          .height_m = static_cast<double>(m.height_m)};
}

Direction Ellipsoid::directionFromBody(const BodyPosition& p) const {
  const Meridian m = meridianOf(p, static_cast<Wide>(a_), static_cast<Wide>(f_));
  const Wide scale = m.fromAxis_m == 0 ? Wide{0} : m.cosLat / m.fromAxis_m;
  return {Vec3(static_cast<double>(static_cast<Wide>(p.m.x) * scale),
               static_cast<double>(static_cast<Wide>(p.m.y) * scale), static_cast<double>(m.sinLat))};
}

std::optional<double> Ellipsoid::intersect(const Ray& ray, double height_m) const {
  const double equatorial = a_ + height_m;
  const double polar = semiMinorAxis_m() + height_m;
  if (!(equatorial > 0.0 && polar > 0.0)) return std::nullopt;
  const Vec3 origin = scaledToUnit(ray.origin.m, equatorial, polar);
  const Vec3 direction = scaledToUnit(ray.direction, equatorial, polar);
  const double speed2 = dot(direction, direction);
  if (!(speed2 > 0.0)) return std::nullopt;
  const double nearest = -dot(origin, direction) / speed2;
  const Vec3 nearestPoint = origin + nearest * direction;
  const double halfChord2 = (1.0 - dot(nearestPoint, nearestPoint)) / speed2;
  const double outside = (dot(origin, origin) - 1.0) / speed2;  // the product of the two crossings
  if (outside > 0.0 && (nearest <= 0.0 || !(halfChord2 >= 0.0))) return std::nullopt;
  if (std::isnan(outside) || std::isnan(nearest)) return std::nullopt;
  if (outside == 0.0) return 0.0;
  const double halfChord = std::sqrt(std::max(halfChord2, 0.0));
  if (outside > 0.0) return outside / (nearest + halfChord);
  return nearest >= 0.0 ? nearest + halfChord : -outside / (halfChord - nearest);
}

Horizon Ellipsoid::horizon(const BodyPosition& eye, double depth_m) const {
  constexpr double kRounding = 1e-14;  // of squared semi-axes: 30 nm of height on Earth, for the "only when hidden"
  Horizon horizon;
  const double equatorial = a_ - depth_m;
  const double polar = semiMinorAxis_m() - depth_m;
  if (!(equatorial > 0.0 && polar > 0.0)) return horizon;
  horizon.eye_ = eye.m;
  horizon.scale_ = Vec3(1.0 / equatorial, 1.0 / equatorial, 1.0 / polar);
  horizon.from_ = scaledToUnit(eye.m, equatorial, polar);
  const double tangent2 = dot(horizon.from_, horizon.from_) * (1.0 + kRounding) - 1.0;
  if (tangent2 > 0.0) horizon.tangent2_ = tangent2 + kRounding;
  return horizon;
}

}  // namespace tellurion::geo
