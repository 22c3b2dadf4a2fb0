#include "raster/doubling_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "raster/projection.h"

namespace tellurion::raster {
namespace {

double mercatorY(double latitude_degrees, double radius_m) {
  const double y = std::asinh(std::tan(latitude_degrees * geo::kPi / 180.0)) * radius_m;
  return std::clamp(y, -geo::kPi * radius_m, geo::kPi * radius_m);
}

std::optional<PlaneBox> projectedBox(const std::string& definition, const PlaneBox& degrees) {
  const auto projection = Projection::fromWgs84(definition, std::nullopt);
  if (!projection) return std::nullopt;
  constexpr int kSteps = 16;
  std::vector<double> x;
  std::vector<double> y;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      x.push_back(degrees.left + (degrees.right - degrees.left) * i / kSteps);
      y.push_back(degrees.bottom + (degrees.top - degrees.bottom) * j / kSteps);
    }
  }
  projection->forward(x, y);
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PlaneBox box{kFar, kFar, -kFar, -kFar};
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    box = {std::min(box.left, x[i]), std::min(box.bottom, y[i]), std::max(box.right, x[i]), std::max(box.top, y[i])};
  }
  if (!(box.right > box.left) || !(box.top > box.bottom)) return std::nullopt;
  // Between the points that were tried the edge may bulge.
  const double margin = 0.02 * std::max(box.right - box.left, box.top - box.bottom);
  return PlaneBox{box.left - margin, box.bottom - margin, box.right + margin, box.top + margin};
}

}  // namespace

std::optional<PlaneBox> planeBox(const MapPlane& plane, const geo::GeoRect& rect, const geo::Body& body) {
  PlaneBox degrees{rect.west.degrees(), rect.south.degrees(), rect.east().degrees(), rect.north.degrees()};
  if (degrees.right > 180.0 + 1e-9) degrees = {-180.0, degrees.bottom, 180.0, degrees.top};
  const double radius_m = body.ellipsoid.semiMajorAxis_m();
  switch (plane.kind) {
    case MapPlane::Kind::lonLat:
      return degrees;
    case MapPlane::Kind::webMercator:
      return PlaneBox{degrees.left * geo::kPi / 180.0 * radius_m, mercatorY(degrees.bottom, radius_m),
                      degrees.right * geo::kPi / 180.0 * radius_m, mercatorY(degrees.top, radius_m)};
    case MapPlane::Kind::other:
      return projectedBox(plane.definition, degrees);
  }
  return std::nullopt;
}

DoublingGrid doublingGrid(const MapPlane& plane, const PlaneBox& box, const geo::Body& body) {
  switch (plane.kind) {
    case MapPlane::Kind::lonLat:
      return {-180.0, 90.0, 180.0, 2, 1};
    case MapPlane::Kind::webMercator: {
      const double half = geo::kPi * body.ellipsoid.semiMajorAxis_m();
      return {-half, half, 2.0 * half, 1, 1};
    }
    case MapPlane::Kind::other:
      break;
  }
  const double widest = std::max(box.right - box.left, box.top - box.bottom);
  const double side = std::exp2(std::ceil(std::log2(widest)));
  const double left = std::floor(box.left / side);
  const double top = std::ceil(box.top / side);
  return {left * side, top * side, side, static_cast<std::int64_t>(std::ceil(box.right / side) - left),
          static_cast<std::int64_t>(top - std::floor(box.bottom / side))};
}

GridLevel levelOf(const DoublingGrid& grid, int level, int imagePixels) {
  GridLevel made;
  made.left = grid.left;
  made.top = grid.top;
  made.pixelWidth = made.pixelHeight = std::ldexp(grid.side / imagePixels, -level);
  made.imageWidth = made.imageHeight = imagePixels;
  made.endColumn = made.columns = grid.columns << level;
  made.endRow = made.rows = grid.rows << level;
  return made;
}

std::vector<GridLevel> overviewLevels(const MapPlane& plane, const DoublingGrid& grid, int imagePixels) {
  constexpr int kCoarsest = 256;  // pixels around the body
  std::vector<GridLevel> levels;
  if (plane.kind == MapPlane::Kind::other) return levels;
  const int columns = static_cast<int>(grid.columns);
  const int rows = static_cast<int>(grid.rows);
  int around = imagePixels * columns;
  for (int halvings = 1; around > kCoarsest && around % (2 * columns) == 0; ++halvings) {
    around /= 2;
    GridLevel level{.left = grid.left,
                    .top = grid.top,
                    .pixelWidth = std::ldexp(grid.side / imagePixels, halvings),
                    .pixelHeight = std::ldexp(grid.side / imagePixels, halvings),
                    .imageWidth = around,
                    .imageHeight = around / columns * rows};
    level.columns = level.endColumn = level.rows = level.endRow = 1;
    levels.insert(levels.begin(), level);
  }
  return levels;
}

bool limitTo(const PlaneBox& box, GridLevel& level) {
  constexpr double kTouch = 1e-6;  // of an image: an edge that only touches is not inside
  const auto place = [](double distance, double side, std::int64_t count) {
    return std::clamp(distance / side, 0.0, static_cast<double>(count));
  };
  const double width = level.pixelWidth * level.imageWidth;
  const double height = level.pixelHeight * level.imageHeight;
  const auto first = [](double at) { return static_cast<std::int64_t>(std::floor(at + kTouch)); };
  const auto end = [](double at) { return static_cast<std::int64_t>(std::ceil(at - kTouch)); };
  level.firstColumn = std::max(level.firstColumn, first(place(box.left - level.left, width, level.columns)));
  level.endColumn = std::min(level.endColumn, end(place(box.right - level.left, width, level.columns)));
  level.firstRow = std::max(level.firstRow, first(place(level.top - box.top, height, level.rows)));
  level.endRow = std::min(level.endRow, end(place(level.top - box.bottom, height, level.rows)));
  return level.firstColumn < level.endColumn && level.firstRow < level.endRow;
}

}  // namespace tellurion::raster
