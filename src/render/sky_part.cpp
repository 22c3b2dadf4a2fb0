#include "render/sky_part.h"

#include <algorithm>
#include <cmath>

#include "geo/vector.h"

namespace tellurion::render {
namespace {

using air_shading::kSkyBands;
using air_shading::kSkyColumns;

// Scaled axes turn directions a little against the body's, bands and columns are straight between their corners.
constexpr double kMargin_rad = 0.02;
// Light between rows is interpolated; within a whole pixel that shows near the horizon.
constexpr double kRowsApart_px = 0.5;
// Below the horizon: farther than the dome's lowest row reaches.
constexpr double kBelow_rad = 0.5;

/// Beyond the horizon, as domeDirection() in sky.vert.glsl has it.
double angleOfRow(int row, const air_shading::AirView& air) {
  if (row == 0) return -kBelow_rad;
  const double upwards = static_cast<double>(row - 1) / (kSkyBands - 1);
  return 2.0 * std::atan(upwards * upwards * upwards / static_cast<double>(air.horizon.w));
}

/// A cone about the view axis that holds the picture, as angles from the nadir and from AirView::side.
struct Cone {
  double nadir = 0.0;
  double azimuth = 0.0;
  double half = 0.0;
};

Cone coneOf(const scene::View& view, const air_shading::AirView& air) {
  const geo::Vec3 axis =
      geo::normalize(glm::transpose(view.viewFromBody) * geo::Vec3(0, 0, -1) * geo::Vec3(geo::Vec4(air.scale)));
  const geo::Vec3 up(geo::Vec4(air.up));
  const geo::Vec3 side(geo::Vec4(air.side));
  const scene::Sides sides = view.sides();
  const double x = std::max(std::abs(sides.left), std::abs(sides.right));
  const double y = std::max(std::abs(sides.bottom), std::abs(sides.top));
  return {.nadir = std::acos(std::clamp(-geo::dot(axis, up), -1.0, 1.0)),
          .azimuth = std::atan2(geo::dot(axis, geo::cross(up, side)), geo::dot(axis, side)),
          .half = std::atan(std::hypot(x, y)) + kMargin_rad};
}

}  // namespace

SkyPart skyPartOf(const scene::View& view, const air_shading::AirView& air) {
  const Cone cone = coneOf(view, air);
  const double horizon = std::atan2(static_cast<double>(air.horizon.x), static_cast<double>(air.horizon.y));
  const double apart = kRowsApart_px * view.pixelAngle();
  SkyPart part;
  const auto isSeen = [&](int from, int to) {
    return horizon + angleOfRow(to, air) > cone.nadir - cone.half &&
           horizon + angleOfRow(from, air) < cone.nadir + cone.half;
  };
  for (int row = 0; row < kSkyBands;) {
    int next = row + 1;
    while (row > 0 && next < kSkyBands && angleOfRow(next + 1, air) - angleOfRow(row, air) <= apart)
      ++next;
    if (isSeen(row, next)) {
      if (part.bandCount == 0) part.rows[0] = row;
      part.rows[static_cast<std::size_t>(++part.bandCount)] = next;
    }
    row = next;
  }
  if (cone.nadir <= cone.half || cone.nadir + cone.half >= geo::kPi) {
    part.columnCount = kSkyColumns;
    return part;
  }
  const double column = 2.0 * geo::kPi / kSkyColumns;
  const double reach = std::asin(std::min(std::sin(cone.half) / std::sin(cone.nadir), 1.0));
  const int first = static_cast<int>(std::floor((cone.azimuth - reach) / column));
  const int last = static_cast<int>(std::ceil((cone.azimuth + reach) / column));
  part.firstColumn = ((first % kSkyColumns) + kSkyColumns) % kSkyColumns;
  part.columnCount = std::clamp(last - first, 2, kSkyColumns);
  return part;
}

}  // namespace tellurion::render
