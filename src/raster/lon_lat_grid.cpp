#include "raster/lon_lat_grid.h"

#include <algorithm>
#include <cmath>

namespace tellurion::raster {
namespace {

constexpr double kCircle = 2.0 * geo::kPi;
constexpr double kWholeCircle_rad = kCircle - 1e-9;

}  // namespace

bool LonLatGrid::wraps() const {
  return bounds.width.radians() >= kWholeCircle_rad;
}

geo::Angle LonLatGrid::latitude(int row) const {
  return bounds.north - (bounds.north - bounds.south) * ((row + 0.5) / height);
}

std::vector<geo::Direction> LonLatGrid::places(int row) const {
  std::vector<geo::Direction> places(static_cast<std::size_t>(width));
  const geo::Angle lat = latitude(row);
  for (int col = 0; col < width; ++col) {
    places[static_cast<std::size_t>(col)] =
        geo::directionFromLatLon(lat, geo::wrappedLongitude(bounds.west + bounds.width * ((col + 0.5) / width)));
  }
  return places;
}

double LonLatGrid::rowStep_m(const geo::Body& body) const {
  return (bounds.north - bounds.south).radians() / height * body.ellipsoid.meanRadius_m();
}

double LonLatGrid::columnStep_m(const geo::Body& body, int row) const {
  return bounds.width.radians() / width * std::cos(latitude(row).radians()) * body.ellipsoid.meanRadius_m();
}

LonLatGrid::Spot LonLatGrid::spotOf(const geo::Direction& place) const {
  const geo::Geodetic where = geo::geodeticFromDirection(place);
  // From the middle of the rectangle, so that what lies outside is taken to the nearer side.
  const geo::Angle fromMiddle = geo::wrappedLongitude(where.lon - (bounds.west + bounds.width / 2.0));
  const double x = (fromMiddle / bounds.width + 0.5) * width - 0.5;
  const double y = (bounds.north - where.lat) / (bounds.north - bounds.south) * height - 0.5;
  Spot spot;
  const double left = std::floor(wraps() ? x : std::clamp(x, 0.0, width - 1.0));
  const double top = std::floor(std::clamp(y, 0.0, height - 1.0));
  const int col = static_cast<int>(left);
  spot.row0 = static_cast<int>(top);
  spot.row1 = std::min(spot.row0 + 1, height - 1);
  spot.right = wraps() ? x - left : std::clamp(x, 0.0, width - 1.0) - left;
  spot.down = std::clamp(y, 0.0, height - 1.0) - top;
  spot.col0 = wraps() ? (col + width) % width : col;
  spot.col1 = wraps() ? (col + 1 + width) % width : std::min(col + 1, width - 1);
  return spot;
}

LonLatGrid gridOfSpacing(const geo::GeoRect& bounds, geo::Angle spacing, int mostNodes) {
  const bool holdsEquator = bounds.south.radians() <= 0.0 && bounds.north.radians() >= 0.0;
  const double nearest =
      holdsEquator ? 0.0 : std::min(std::abs(bounds.south.radians()), std::abs(bounds.north.radians()));
  const auto nodes = [&](double extent) {
    const double wanted = std::ceil(extent / spacing.radians() - 1e-6);  // rounding makes no step more
    return wanted >= mostNodes ? mostNodes : std::max(1, static_cast<int>(wanted));
  };
  return {.bounds = bounds,
          .width = nodes(bounds.width.radians() * std::cos(nearest)),
          .height = nodes((bounds.north - bounds.south).radians())};
}

}  // namespace tellurion::raster
