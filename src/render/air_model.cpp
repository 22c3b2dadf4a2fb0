#include "render/air_model.h"

#include <algorithm>
#include <cmath>

namespace tellurion::render {
namespace {

using air_shading::AirModel;
using air_shading::AirView;
using geo::Vec3;
using geo::Vec3f;
using geo::Vec4f;

/// Below this an eye's air is no more than that of one which stands there.
constexpr double kLeastOverBottom_m = 1.0;

/// Above this share of the air's height an eye looks down on nearly all of it.
constexpr double kThinAir = 0.5;

/// Of matter that thins out by e in each `scale_m`, from the optical depth above height 0: what a metre at height 0
/// takes away. What lies above the top is little, and left out.
Vec3f aMetre(const scene::ThreeBands& depth, double scale_m) {
  return bandsOf(depth) / static_cast<float>(scale_m);
}

/// A unit vector across `up`, in the half plane that `towards` lies in; any where there is none.
Vec3 acrossTowards(const Vec3& up, const Vec3& towards) {
  const Vec3 flat = towards - up * geo::dot(towards, up);
  const double length = geo::length(flat);
  if (length > 1e-9) return flat / length;
  const Vec3 other = std::abs(up.z) < 0.9 ? Vec3(0.0, 0.0, 1.0) : Vec3(1.0, 0.0, 0.0);
  return geo::normalize(geo::cross(up, other));
}

Vec4f four(double x, double y, double z, double w) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

}  // namespace

Vec3f bandsOf(const scene::ThreeBands& values) {
  return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

AirModel airModelOf(const scene::Atmosphere& atmosphere, double radius_m) {
  const Vec3f aerosol = aMetre(atmosphere.aerosolDepth, atmosphere.aerosolHeight_m);
  const auto inverse = [](double metres) { return static_cast<float>(1.0 / metres); };
  const auto sunRadius = static_cast<float>(geo::Angle::degrees(atmosphere.sunRadius_degrees).radians());
  return {.gas = Vec4f(aMetre(atmosphere.gasDepth, atmosphere.gasHeight_m), inverse(atmosphere.gasHeight_m)),
          .aerosolScattering = Vec4f(aerosol * bandsOf(atmosphere.aerosolAlbedo), inverse(atmosphere.aerosolHeight_m)),
          .aerosolExtinction = Vec4f(aerosol, sunRadius),
          .aerosolForward = Vec4f(bandsOf(atmosphere.aerosolForward), inverse(atmosphere.ozoneReach_m)),
          // A tent as wide as twice its reach holds what its top would within its reach.
          .ozone = Vec4f(aMetre(atmosphere.ozoneDepth, atmosphere.ozoneReach_m),
                         static_cast<float>(atmosphere.ozoneMiddle_m)),
          .sphere = four(radius_m, atmosphere.bottom_m, atmosphere.top_m, 0.0)};
}

Vec3 airFromBody(const geo::Ellipsoid& ellipsoid) {
  const double r = ellipsoid.meanRadius_m();
  return {r / ellipsoid.semiMajorAxis_m(), r / ellipsoid.semiMajorAxis_m(), r / ellipsoid.semiMinorAxis_m()};
}

EyeInAir eyeInAir(const geo::Ellipsoid& ellipsoid, const geo::BodyPosition& eye, const Vec3& toSun_body) {
  const Vec3 scale = airFromBody(ellipsoid);
  const Vec3 at = eye.m * scale;
  const double r = geo::length(at);
  EyeInAir out{.up = r > 0.0 ? at / r : Vec3(0.0, 0.0, 1.0),
               .toSun = geo::normalize(toSun_body * scale),
               .height_m = r - ellipsoid.meanRadius_m()};
  out.sunCosine = geo::dot(out.up, out.toSun);
  return out;
}

AirView airViewOf(const scene::Atmosphere& atmosphere, const geo::Ellipsoid& ellipsoid, const EyeInAir& eye) {
  const Vec3 scale = airFromBody(ellipsoid);
  const double radius = ellipsoid.meanRadius_m();
  const double bottom = radius + atmosphere.bottom_m;
  const double top = radius + atmosphere.top_m;
  const double r = std::max(radius + eye.height_m, bottom + kLeastOverBottom_m);
  const bool outside = r > top;
  const bool isHigh = eye.height_m > kThinAir * atmosphere.top_m;
  const Vec3 side = acrossTowards(eye.up, eye.toSun);
  const double overBottom2 = (r - bottom) * (r + bottom);
  const double underTop2 = (top - r) * (top + r);
  const double sine = bottom / r;
  const double cosine = std::sqrt(overBottom2) / r;
  const double topSine = outside ? top / r : 1.0;
  const double topCosine = outside ? std::sqrt(-underTop2) / r : 0.0;
  // Tangents of half the angles from the horizon to the nadir, and to the zenith or the top of the air.
  const double toNadir = -sine / (1.0 + cosine);
  const double upTo = outside ? std::atan2(topSine, topCosine) : geo::kPi;
  const double toTop = std::tan((upTo - std::atan2(sine, cosine)) / 2.0);
  return {.scale = four(scale.x, scale.y, scale.z, r),
          .up = Vec4f(Vec3f(eye.up), 1.0f),
          .side = Vec4f(Vec3f(side), outside  ? air_shading::kEyeOutside
                                     : isHigh ? air_shading::kEyeHigh
                                              : air_shading::kEyeLow),
          .toSun = Vec4f(Vec3f(eye.toSun), 0.0f),
          .horizon = four(sine, cosine, 1.0 / toNadir, 1.0 / toTop),
          .top = four(topSine, topCosine, outside ? (top - bottom) * (top + bottom) : overBottom2, underTop2)};
}

}  // namespace tellurion::render
