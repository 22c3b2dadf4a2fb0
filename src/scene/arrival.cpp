#include "scene/arrival.h"

#include <algorithm>
#include <cmath>

#include "scene/navigation.h"

namespace tellurion::scene {
namespace {

constexpr double kDefaultSize_m = 20e3;
constexpr double kLeastSize_m = 200.0;

View above(geo::Angle lat, geo::Angle lon, double overGround_m, const View& now, const Ground& ground) {
  const Camera camera{
      .position = {.lat = lat,
                   .lon = lon,
                   .height_m = ground.heightOrZero_m(geo::directionFromLatLon(lat, lon)) + overGround_m},
      .heading = {},
      .pitch = geo::Angle::degrees(-90.0),
      .roll = {}};
  return cleared(viewOf(camera, ground.ellipsoid, now.verticalFov, now.viewport), ground);
}

}  // namespace

View arrivalAt(const WrittenPlace& place, const View& now, const Ground& ground) {
  if (place.hasHeight) return cleared(viewOf(place.camera, ground.ellipsoid, now.verticalFov, now.viewport), ground);
  const double over_m = std::min(heightAboveGround_m(now.eye, ground), ground.ellipsoid.semiMajorAxis_m() / 600.0);
  return above(place.camera.position.lat, place.camera.position.lon, over_m, now, ground);
}

View arrivalAt(const Place& place, const View& now, const Ground& ground) {
  const double size_m = std::max(place.size_m > 0.0 ? place.size_m : kDefaultSize_m, kLeastSize_m);
  const double over_m = 0.75 * size_m / std::tan(0.5 * now.verticalFov.radians());
  return above(place.lat, place.lon, std::min(over_m, 3.0 * ground.ellipsoid.semiMajorAxis_m()), now, ground);
}

}  // namespace tellurion::scene
