#include "truth/ray_caster.h"

#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <GeographicLib/Geocentric.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace tellurion::truth {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

/// Both crossings of a ray with a sphere about the centre; false when it misses.
bool crossSphere(const geo::Ray& ray, double radius_m, double& near_m, double& far_m) {
  const double b = geo::dot(ray.origin.m, ray.direction);
  const double c = geo::dot(ray.origin.m, ray.origin.m) - radius_m * radius_m;
  const double discriminant = b * b - c;
  if (discriminant < 0) return false;
  near_m = -b - std::sqrt(discriminant);
  far_m = -b + std::sqrt(discriminant);
  return true;
}

/// On an ellipsoid; degrees.
struct Place {
  double lat = 0;
  double lon = 0;
  double height_m = 0;
};

GeographicLib::Geocentric geocentricOf(const geo::Ellipsoid& e) {
  return {e.semiMajorAxis_m(), e.flattening()};
}

Place placeOf(const GeographicLib::Geocentric& geocentric, const geo::Ray& ray, double distance_m) {
  const geo::Vec3 p = ray.origin.m + ray.direction * distance_m;
  Place place;
  geocentric.Reverse(p.x, p.y, p.z, place.lat, place.lon, place.height_m);
  return place;
}

/// The first place found to be under the ground, from a distance on; `height_m` tells the ground of a place in degrees.
/// No step is shorter than leastStep_m, or than a fifth of a pixel.
template <class Height>
double march(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle, double leastStep_m, double from_m,
             const Height& height_m) {
  const geo::Ellipsoid& e = surface.ellipsoid();
  const GeographicLib::Geocentric geocentric = geocentricOf(e);
  double near_m = 0;
  double far_m = 0;
  if (!crossSphere(ray, e.semiMajorAxis_m() + surface.highest_m(), near_m, far_m) || far_m < 0) return kNever;

  const auto gapAt = [&](double distance) {
    const Place p = placeOf(geocentric, ray, distance);
    return p.height_m - height_m(p.lat, p.lon);
  };
  double before = std::max(near_m, from_m);
  double gap = gapAt(before);
  if (gap < 0) return before;
  while (before < far_m) {
    // No source here rises more steeply than 3 in 1 between its samples.
    const double after = before + std::max({gap * 0.3, leastStep_m, before * pixelAngle / 5});
    gap = gapAt(after);
    if (gap < 0) {
      double above = before;
      double below = after;
      for (int i = 0; i < 50 && below - above > 1e-4; ++i) {
        const double middle = (above + below) / 2;
        (gapAt(middle) < 0 ? below : above) = middle;
      }
      return below;
    }
    before = after;
  }
  return kNever;
}

}  // namespace

/// The places of the raster's four corners, in its own reference's degrees, and a table over them with some room.
SourceSurface::PlaceTable SourceSurface::tableOf(GDALDataset& dataset, const std::array<double, 6>& affine) {
  const OGRSpatialReference& projected = *dataset.GetSpatialRef();
  const std::unique_ptr<OGRSpatialReference> geographic(projected.CloneGeogCS());
  geographic->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  const std::unique_ptr<OGRCoordinateTransformation> toDegrees(
      OGRCreateCoordinateTransformation(&projected, geographic.get()));
  const std::unique_ptr<OGRCoordinateTransformation> fromDegrees(
      OGRCreateCoordinateTransformation(geographic.get(), &projected));
  if (!toDegrees || !fromDegrees) throw std::runtime_error("no way from a raster's projection to degrees");
  double west = 360;
  double east = -360;
  double south = 90;
  double north = -90;
  for (const double col : {0.0, 1.0}) {
    for (const double row : {0.0, 1.0}) {
      double lon = affine[0] + affine[1] * col * dataset.GetRasterXSize();
      double lat = affine[3] + affine[5] * row * dataset.GetRasterYSize();
      toDegrees->Transform(1, &lon, &lat);
      west = std::min(west, lon);
      east = std::max(east, lon);
      south = std::min(south, lat);
      north = std::max(north, lat);
    }
  }
  PlaceTable table;
  table.stepLon = 1.2 * (east - west) / PlaceTable::kCells;
  table.stepLat = 1.2 * (north - south) / PlaceTable::kCells;
  table.west = west - 0.1 * (east - west);
  table.south = south - 0.1 * (north - south);
  std::size_t i = 0;
  for (int row = 0; row <= PlaceTable::kCells; ++row) {
    for (int col = 0; col <= PlaceTable::kCells; ++col, ++i) {
      table.x[i] = table.west + col * table.stepLon;
      table.y[i] = table.south + row * table.stepLat;
    }
  }
  fromDegrees->Transform(static_cast<int>(i), table.x.data(), table.y.data());
  return table;
}

bool SourceSurface::PlaceTable::find(double lat, double lon, double& outX, double& outY) const {
  const double c = (lon - west) / stepLon;
  const double r = (lat - south) / stepLat;
  if (!(c >= 0 && c < kCells && r >= 0 && r < kCells)) return false;
  const auto col = static_cast<std::size_t>(c);
  const auto row = static_cast<std::size_t>(r);
  const auto between = [&](const auto& of) {
    const std::size_t i = row * (kCells + 1) + col;
    const double below = std::lerp(of[i], of[i + 1], c - static_cast<double>(col));
    const double over = std::lerp(of[i + kCells + 1], of[i + kCells + 2], c - static_cast<double>(col));
    return std::lerp(below, over, r - static_cast<double>(row));
  };
  outX = between(x);
  outY = between(y);
  return true;
}

SourceSurface::Layer SourceSurface::read(const std::string& path, const geo::Ellipsoid& ellipsoid) {
  GDALAllRegister();
  auto* dataset = static_cast<GDALDataset*>(GDALOpen(path.c_str(), GA_ReadOnly));
  if (dataset == nullptr) throw std::runtime_error("cannot open " + path);
  std::array<double, 6> affine{};
  dataset->GetGeoTransform(affine.data());
  Layer layer;
  layer.width = dataset->GetRasterXSize();
  layer.height = dataset->GetRasterYSize();
  layer.stepX = affine[1];
  layer.stepY = -affine[5];
  layer.west = affine[0] + affine[1] / 2;
  layer.north = affine[3] + affine[5] / 2;
  const OGRSpatialReference* reference = dataset->GetSpatialRef();
  if (reference != nullptr && reference->IsProjected() != 0) layer.projection = tableOf(*dataset, affine);
  layer.spacing_m = layer.projection ? layer.stepY : layer.stepY * geo::kPi / 180.0 * ellipsoid.meanRadius_m();
  layer.wraps = !layer.projection && std::abs(layer.width * layer.stepX - 360.0) < layer.stepX / 2;
  GDALRasterBand* band = dataset->GetRasterBand(1);
  int hasNoData = 0;
  layer.noData = band->GetNoDataValue(&hasNoData);
  layer.hasNoData = hasNoData != 0;
  layer.samples.resize(static_cast<std::size_t>(layer.width) * static_cast<std::size_t>(layer.height));
  const CPLErr error = band->RasterIO(GF_Read, 0, 0, layer.width, layer.height, layer.samples.data(), layer.width,
                                      layer.height, GDT_Float32, 0, 0);
  GDALClose(dataset);
  if (error != CE_None) throw std::runtime_error("cannot read " + path);
  return layer;
}

double SourceSurface::Layer::at(int col, int row) const {
  if (wraps) {
    // Past a pole the meridian goes on half a turn away.
    if (row < 0 || row >= height) col += width / 2;
    if (row < 0) row = -1 - row;
    if (row >= height) row = 2 * height - 1 - row;
    col = ((col % width) + width) % width;
  }
  col = std::clamp(col, 0, width - 1);
  row = std::clamp(row, 0, height - 1);
  const auto v = static_cast<double>(
      samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(col)]);
  return hasNoData && v == noData ? kNever : v;
}

SourceSurface::Cover SourceSurface::Layer::sample(double lat, double lon, double& value) const {
  double easting = lon;
  double northing = lat;
  if (projection && !projection->find(lat, lon, easting, northing)) return Cover::none;
  double x = (easting - west) / stepX;
  const double y = (north - northing) / stepY;
  const double turn = 360.0 / stepX;
  if (!projection) x -= turn * std::floor((x + 1) / turn);  // to [-1, turn - 1)
  if (!wraps && (x <= -1 || x >= width)) return Cover::none;
  if (y <= -1 || y >= height) return Cover::none;
  const int col = static_cast<int>(std::floor(x));
  const int row = static_cast<int>(std::floor(y));
  double sum = 0;
  double weights = 0;
  double missing = 0;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const double weight = (dx != 0 ? x - col : 1 - (x - col)) * (dy != 0 ? y - row : 1 - (y - row));
      const double v = at(col + dx, row + dy);
      const bool isSample = wraps || (col + dx >= 0 && col + dx < width && row + dy >= 0 && row + dy < height);
      if (std::isnan(v) || !isSample) missing += weight;
      if (std::isnan(v)) continue;
      sum += weight * v;
      weights += weight;
    }
  }
  if (weights == 0) return Cover::none;
  value = sum / weights;
  if (missing == 0) return Cover::within;
  const bool isOnIt = (wraps || (x >= -0.5 && x <= width - 0.5)) && y >= -0.5 && y <= height - 0.5;
  const bool isNearest = isOnIt && !std::isnan(at(static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y))));
  return isNearest ? Cover::nearest : Cover::beside;
}

SourceSurface::SourceSurface(const std::vector<std::string>& rasterPaths, const geo::Ellipsoid& ellipsoid)
    : ellipsoid_(ellipsoid), spacing_(std::numeric_limits<double>::infinity()) {
  for (const std::string& path : rasterPaths) {
    layers_.push_back(read(path, ellipsoid));
    const Layer& layer = layers_.back();
    for (const float v : layer.samples) {
      if (layer.hasNoData && static_cast<double>(v) == layer.noData) continue;
      lowest_ = std::min(lowest_, static_cast<double>(v));
      highest_ = std::max(highest_, static_cast<double>(v));
    }
    spacing_ = std::min(spacing_, layer.spacing_m);
  }
}

double SourceSurface::height_m(double lat, double lon) const {
  double value = 0;
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer)
    if (layer->sample(lat, lon, value) >= Cover::nearest) return value;
  return 0;
}

SourceSurface::Heights SourceSurface::heights(double lat, double lon) const {
  Heights all{.low_m = std::numeric_limits<double>::infinity(), .high_m = -std::numeric_limits<double>::infinity()};
  const auto mayBe = [&](double height_m) {
    all = {.low_m = std::min(all.low_m, height_m), .high_m = std::max(all.high_m, height_m)};
  };
  double value = 0;
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
    const Cover cover = layer->sample(lat, lon, value);
    if (cover != Cover::none) mayBe(value);
    if (cover == Cover::within) return all;
  }
  mayBe(0);
  return all;
}

double SourceSurface::spacing_m(double lat, double lon) const {
  double value = 0;
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer)
    if (layer->sample(lat, lon, value) >= Cover::nearest) return layer->spacing_m;
  return std::numeric_limits<double>::infinity();
}

double distanceAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle) {
  return march(surface, ray, pixelAngle, surface.smallestSpacing_m() / 5, 0.0,
               [&](double lat, double lon) { return surface.height_m(lat, lon); });
}

Seen seenAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle) {
  const double step_m = surface.smallestSpacing_m() / 5;
  const double nearest_m = march(surface, ray, pixelAngle, step_m, 0.0,
                                 [&](double lat, double lon) { return surface.heights(lat, lon).high_m; });
  if (std::isnan(nearest_m)) return exactly(kNever);
  const Place met = placeOf(geocentricOf(surface.ellipsoid()), ray, nearest_m);
  if (const auto there = surface.heights(met.lat, met.lon); there.low_m == there.high_m) return exactly(nearest_m);
  const double farthest_m = march(surface, ray, pixelAngle, step_m, nearest_m,
                                  [&](double lat, double lon) { return surface.heights(lat, lon).low_m; });
  return {.nearest_m = nearest_m, .farthest_m = farthest_m};
}

double distanceFinelyAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle) {
  return march(surface, ray, pixelAngle, 0.1, 0.0, [&](double lat, double lon) { return surface.height_m(lat, lon); });
}

}  // namespace tellurion::truth
