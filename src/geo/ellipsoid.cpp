#include "geo/ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tellurion::geo {

namespace {

// The way back from the body frame ends in long double: where that is wider than a double (x86 Linux), its own error
// stays below the rounding of what goes in and out.
using Wide = long double;

// A place in the meridian plane of a point, with what its normal needs. The latitude is that of the two, of about unit
// length, and `turn` radians more, which they are too coarse to say.
struct Meridian {
  Wide cosLat;
  Wide sinLat;
  Wide height_m;
  Wide fromAxis_m;
  Wide turn = 0;
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

// Bowring's formula ("Transformation from spatial to geographical coordinates", 1976) in double precision, then one
// step of Newton's method for the foot of the perpendicular. The step says how far off the formula was: where that is
// more than kNewtonReach, and near the evolute, where the step might lead to another foot, nothing.
//
// With F(lat) = R sin - Z cos - e^2 N sin cos, F' is the distance from the centre of curvature and |F''| < 5 e^2 a, so
// that kNewtonReach^2 |F'' / 2 F'| < 1e-20 rad is left.
std::optional<Meridian> quickMeridian(Wide fromAxis_m, Wide z_m, double a, double flattening) {
  constexpr double kGreatestEccentricity2 = 0.02;  // Saturn, 0.19, goes the other way
  constexpr double kLeastDistance = 0.5;           // of a; the evolute lies within e^2 of it
  constexpr double kNewtonReach = 3e-10;
  const double e2 = flattening * (2.0 - flattening);
  const auto r = static_cast<double>(fromAxis_m) / a;
  const auto z = static_cast<double>(z_m) / a;
  const double distance2 = r * r + z * z;
  constexpr double kFarthest2 = 1e12;  // beyond, squares might overflow soon
  if (!(e2 <= kGreatestEccentricity2 && distance2 >= kLeastDistance * kLeastDistance && distance2 <= kFarthest2))
    return std::nullopt;

  const double oneMinusF = 1.0 - flattening;
  const double primed = e2 / oneMinusF;  // e'^2 b, as a share of a
  const double reducedSin = z * (std::sqrt(distance2) + primed);
  const double reducedCos = r * std::sqrt(distance2) / oneMinusF;
  const double reduced2 = reducedSin * reducedSin + reducedCos * reducedCos;
  const double reduced3 = reduced2 * std::sqrt(reduced2);
  const double sinTimes = z * reduced3 + primed * (reducedSin * reducedSin * reducedSin);
  const double cosTimes = r * reduced3 - e2 * (reducedCos * reducedCos * reducedCos);
  const double norm = std::sqrt(sinTimes * sinTimes + cosTimes * cosTimes);
  const double s = sinTimes / norm;
  const double c = cosTimes / norm;

  // What follows takes the two for exact but for their length, 1 + excess / 2.
  const Wide sinLat = s;
  const Wide cosLat = c;
  const Wide wideE2 = static_cast<Wide>(flattening) * (2 - static_cast<Wide>(flattening));
  const Wide excess = sinLat * sinLat + cosLat * cosLat - 1;
  const Wide w2 = 1 - wideE2 * sinLat * sinLat * (1 - excess);
  const Wide w = std::sqrt(w2);
  const Wide foot = wideE2 * a / w * sinLat * cosLat * (1 - excess / 2);
  const Wide height_m = (fromAxis_m * cosLat + z_m * sinLat) * (1 - excess / 2) - a * w;
  const Wide curvature_m = a * (1 - wideE2) / (w2 * w) + height_m;
  const Wide step = (z_m * cosLat - fromAxis_m * sinLat + foot) / curvature_m;
  if (!(std::abs(static_cast<double>(step)) <= kNewtonReach)) return std::nullopt;
  return Meridian{.cosLat = cosLat, .sinLat = sinLat, .height_m = height_m, .fromAxis_m = fromAxis_m, .turn = step};
}

Meridian meridianOf(const BodyPosition& body, double semiMajorAxis_m, double flatteningOfBody) {
  const auto x = static_cast<Wide>(body.m.x);
  const auto y = static_cast<Wide>(body.m.y);
  const auto z = static_cast<Wide>(body.m.z);
  const Wide fromAxis = std::sqrt(x * x + y * y);
  if (const auto quick = quickMeridian(fromAxis, z, semiMajorAxis_m, flatteningOfBody)) return *quick;
  const auto a = static_cast<Wide>(semiMajorAxis_m);
  const auto flattening = static_cast<Wide>(flatteningOfBody);
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
  const Meridian m = meridianOf(p, a_, f_);
  const double lon = m.fromAxis_m == 0 ? 0.0 : std::atan2(p.m.y + 0.0, p.m.x);
  const double lat = std::atan2(static_cast<double>(m.sinLat), static_cast<double>(m.cosLat));
  return {.lat = Angle::radians(static_cast<double>(lat + m.turn)),
          .lon = Angle::radians(lon),
          .height_m = static_cast<double>(m.height_m)};
}

Direction Ellipsoid::directionFromBody(const BodyPosition& p) const {
  const Meridian m = meridianOf(p, a_, f_);
  // The double that is nearest to a sine is off in length as well as in direction.
  const Wide halfExcess = (m.sinLat * m.sinLat + m.cosLat * m.cosLat - 1) / 2;
  const Wide cosLat = m.cosLat - m.sinLat * m.turn - m.cosLat * halfExcess;
  const Wide sinLat = m.sinLat + m.cosLat * m.turn - m.sinLat * halfExcess;
  const Wide scale = m.fromAxis_m == 0 ? Wide{0} : cosLat / m.fromAxis_m;
  return {Vec3(static_cast<double>(static_cast<Wide>(p.m.x) * scale),
               static_cast<double>(static_cast<Wide>(p.m.y) * scale), static_cast<double>(sinLat))};
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

/// What hides a point from a raised eye hides it from all eyes below that, too. With the ellipsoid a unit sphere, the
/// eye at e and the others within r of it, the eye is raised by L = |e| r / (1 - r), to e / (1 - r). If a tangent plane
/// with normal n has the raised eye on the sphere's side, n . e (1 + r / (1 - r)) <= 1, it has all of them there: where
/// the plane is so flat that n . e >= |e| r / L they are lower by L n . e / |e| >= r, and else n . e + r <= |e| r / L +
/// r = 1.
Horizon Ellipsoid::horizon(const BodyPosition& eye, double depth_m, double move_m) const {
  constexpr double kRounding = 1e-14;  // of squared semi-axes: 30 nm of height on Earth, for the "only when hidden"
  Horizon horizon;
  const double equatorial = a_ - depth_m;
  const double polar = semiMinorAxis_m() - depth_m;
  if (!(equatorial > 0.0 && polar > 0.0)) return horizon;
  const double move = move_m / polar;
  const Vec3 from = scaledToUnit(eye.m, equatorial, polar);
  if (move > 0.0 && !(move < 1.0 && length(from) - move > 1.0)) return horizon;
  horizon.eye_ = eye.m / (1.0 - move);
  horizon.scale_ = Vec3(1.0 / equatorial, 1.0 / equatorial, 1.0 / polar);
  horizon.from_ = from / (1.0 - move);
  const double tangent2 = dot(horizon.from_, horizon.from_) * (1.0 + kRounding) - 1.0;
  if (tangent2 > 0.0) horizon.tangent2_ = tangent2 + kRounding;
  return horizon;
}

}  // namespace tellurion::geo
