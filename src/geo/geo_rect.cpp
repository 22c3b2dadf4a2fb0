#include "geo/geo_rect.h"

#include <algorithm>
#include <cmath>

namespace tellurion::geo {

namespace {

constexpr double kTurn = 2.0 * kPi;
constexpr double kHalfPi = kPi / 2.0;

// How far east of `from` the longitude `to` lies, in [0, 360) degrees; what is west of it by no more than the tolerance
// is 0.
double eastwards(Angle from, Angle to) {
  const double east = std::fmod(to.radians() - from.radians(), kTurn);
  const double positive = east < 0.0 ? east + kTurn : east;
  return positive >= kTurn - GeoRect::kTolerance_rad ? 0.0 : positive;
}

bool reachesNorthPole(const GeoRect& r) {
  return r.north.radians() >= kHalfPi;
}
bool reachesSouthPole(const GeoRect& r) {
  return r.south.radians() <= -kHalfPi;
}

}  // namespace

GeoRect GeoRect::whole() {
  return fromDegrees(-90.0, -180.0, 90.0, 180.0);
}

GeoRect GeoRect::fromDegrees(double south, double west, double north, double east) {
  const double width = east < west ? std::fmod(east - west, 360.0) + 360.0 : std::min(east - west, 360.0);
  return {.south = Angle::degrees(south),
          .north = Angle::degrees(north),
          .west = wrappedLongitude(Angle::degrees(west)),
          .width = Angle::degrees(width)};
}

bool GeoRect::contains(Angle lat, Angle lon) const {
  if (!(lat.radians() >= south.radians() - kTolerance_rad && lat.radians() <= north.radians() + kTolerance_rad)) {
    return false;
  }
  if (std::isnan(lon.radians())) return false;
  if (std::fabs(lat.radians()) >= kHalfPi) return true;  // a pole has every longitude
  return eastwards(west, lon) <= width.radians() + kTolerance_rad;
}

bool GeoRect::intersects(const GeoRect& o) const {
  if (!(south.radians() <= o.north.radians() + kTolerance_rad &&
        o.south.radians() <= north.radians() + kTolerance_rad)) {
    return false;
  }
  if ((reachesNorthPole(*this) && reachesNorthPole(o)) || (reachesSouthPole(*this) && reachesSouthPole(o))) return true;
  return eastwards(west, o.west) <= width.radians() + kTolerance_rad ||
         eastwards(o.west, west) <= o.width.radians() + kTolerance_rad;
}

GeoRect GeoRect::united(const GeoRect& o) const {
  const double fromThis = std::max(width.radians(), eastwards(west, o.west) + o.width.radians());
  const double fromOther = std::max(o.width.radians(), eastwards(o.west, west) + width.radians());
  const bool startsHere = fromThis <= fromOther;
  return {.south = std::min(south, o.south),
          .north = std::max(north, o.north),
          .west = startsHere ? west : o.west,
          .width = Angle::radians(std::min(startsHere ? fromThis : fromOther, kTurn))};
}

GeoRect GeoRect::grown(Angle by) const {
  if (by == Angle()) return *this;
  const Angle lower = south - by;
  const Angle upper = north + by;
  const Angle pole = Angle::radians(kHalfPi);
  const bool aroundAPole = lower <= -pole || upper >= pole;
  // A small circle's widest longitude: where a meridian touches it (a right triangle on the sphere).
  const double nearestToPole = std::max(std::fabs(south.radians()), std::fabs(north.radians()));
  const double wider = aroundAPole ? kPi : std::asin(std::min(std::sin(by.radians()) / std::cos(nearestToPole), 1.0));
  const bool allAround = width.radians() + 2.0 * wider >= kTurn;
  return {.south = std::max(lower, -pole),
          .north = std::min(upper, pole),
          .west = allAround ? Angle::degrees(-180.0) : wrappedLongitude(west - Angle::radians(wider)),
          .width = allAround ? Angle::degrees(360.0) : Angle::radians(width.radians() + 2.0 * wider)};
}

}  // namespace tellurion::geo
