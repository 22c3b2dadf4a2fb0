#include "geo/geodetic.h"

#include <cmath>

namespace tellurion::geo {

namespace {

Direction fromSinCos(const SinCos& lat, const SinCos& lon) {
  return {Vec3(lat.cos * lon.cos + 0.0, lat.cos * lon.sin + 0.0, lat.sin)};
}

}  // namespace

Direction directionFromLatLon(Angle lat, Angle lon) {
  return fromSinCos(sinCos(lat), sinCos(lon));
}

Direction directionFromDegrees(double lat, double lon) {
  return fromSinCos(sinCosDegrees(lat), sinCosDegrees(lon));
}

Geodetic geodeticFromDirection(const Direction& d) {
  const double fromAxis = std::hypot(d.n.x, d.n.y);
  const double lon = fromAxis == 0.0 ? 0.0 : std::atan2(d.n.y + 0.0, d.n.x);
  return {.lat = Angle::radians(std::atan2(d.n.z, fromAxis)), .lon = Angle::radians(lon), .height_m = 0.0};
}

Angle angleBetween(const Direction& a, const Direction& b) {
  return Angle::radians(2.0 * std::atan2(length(a.n - b.n), length(a.n + b.n)));
}

}  // namespace tellurion::geo
