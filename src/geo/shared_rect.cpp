#include "geo/shared_rect.h"

#include <algorithm>

namespace tellurion::geo {
namespace {

/// How far east of `from` the longitude `to` lies, [0, 360) degrees.
Angle eastwards(Angle from, Angle to) {
  const Angle way = wrappedLongitude(to - from);
  return way < Angle() ? way + Angle::degrees(360.0) : way;
}

}  // namespace

std::optional<GeoRect> sharedRect(const GeoRect& a, const GeoRect& b) {
  if (!a.intersects(b)) return std::nullopt;
  GeoRect both = b.width < a.width ? b : a;
  both.south = std::max(a.south, b.south);
  both.north = std::min(a.north, b.north);
  const Angle toB = eastwards(a.west, b.west);
  const Angle toA = eastwards(b.west, a.west);
  const bool beginsInA = toB <= a.width;
  const bool beginsInB = toA <= b.width;
  if (beginsInA == beginsInB && !(a.west == b.west)) return both;
  both.west = beginsInA ? b.west : a.west;
  both.width = beginsInA ? std::min(a.width - toB, b.width) : std::min(b.width - toA, a.width);
  return both;
}

}  // namespace tellurion::geo
