#include "app/view_start.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pyramid/pyramid_reader.h"
#include "raster/raster_file.h"
#include "scene/layer_sources.h"

namespace tellurion::app {
namespace {

constexpr double kWholeBody_degrees = 120.0;
/// Room around what is shown, as a share of it.
constexpr double kMargin = 1.15;
constexpr double kLeastHeight_m = 100.0;

std::optional<geo::GeoRect> boundsOf(const std::string& source, raster::Kind kind) {
  if (scene::isTileDatabase(source)) {
    const auto reader = pyramid::PyramidReader::open(source);
    return reader ? std::optional((*reader)->info().bounds) : std::nullopt;
  }
  const auto file = raster::RasterFile::open(source, kind);
  return file ? std::optional(file->info().bounds) : std::nullopt;
}

void add(std::optional<geo::GeoRect>& all, const std::optional<geo::GeoRect>& more) {
  if (more) all = all ? all->united(*more) : *more;
}

/// Of a server, what the scene says: it is not asked here.
std::optional<geo::GeoRect> boundsOf(const raster::ServiceLayer& service) {
  if (!service.bounds_degrees) return geo::GeoRect::whole();
  const auto& [west, south, east, north] = *service.bounds_degrees;
  return geo::GeoRect::fromDegrees(south, west, north, east);
}

template <class Layer>
std::optional<geo::GeoRect> boundsOf(const Layer& layer, raster::Kind kind) {
  switch (layer.from) {
    case scene::SourceKind::service:
      return boundsOf(layer.service);
    case scene::SourceKind::catalogue:
      return std::nullopt;
    case scene::SourceKind::file:
    case scene::SourceKind::live:
      return boundsOf(layer.source, kind);
  }
  return std::nullopt;
}

std::optional<geo::GeoRect> boundsOf(const scene::Scene& scene) {
  std::optional<geo::GeoRect> all;
  for (const auto& layer : scene.elevation)
    add(all, boundsOf(layer, raster::Kind::elevation));
  for (const auto& layer : scene.imagery) {
    if (layer.derived) {
      if (layer.derived->of) add(all, boundsOf(*layer.derived->of, raster::Kind::elevation));
      continue;
    }
    if (!layer.times.empty()) {
      const scene::TimedFile& first = layer.times.front();
      add(all,
          first.from == scene::SourceKind::catalogue ? std::nullopt : boundsOf(first.source, raster::Kind::imagery));
      continue;
    }
    add(all, boundsOf(layer, raster::Kind::imagery));
    for (const std::string& further : layer.alsoFrom)
      add(all, boundsOf(further, raster::Kind::imagery));
  }
  return all;
}

scene::Camera above(double lat, double lon, double height_m) {
  return {.position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon), .height_m = height_m},
          .heading = geo::Angle::degrees(0),
          .pitch = geo::Angle::degrees(-90),
          .roll = geo::Angle::degrees(0)};
}

}  // namespace

scene::Camera startCamera(const scene::Scene& scene, geo::Angle verticalFov) {
  const double radius_m = scene.body.ellipsoid.semiMajorAxis_m();
  const double halfFov = 0.5 * verticalFov.radians();
  const auto bounds = boundsOf(scene);
  if (!bounds || std::max(bounds->width.degrees(), (bounds->north - bounds->south).degrees()) > kWholeBody_degrees)
    return above(20.0, 10.0, radius_m * (kMargin / std::sin(halfFov) - 1.0));
  const double lat = 0.5 * (bounds->north + bounds->south).degrees();
  const double lon = geo::wrappedLongitude(bounds->west + bounds->width * 0.5).degrees();
  const double northSouth = (bounds->north - bounds->south).radians();
  const double westEast = bounds->width.radians() * std::cos(lat * geo::kPi / 180.0);
  const double halfSide_m = 0.5 * kMargin * radius_m * std::max(northSouth, westEast);
  return above(lat, lon, std::max(halfSide_m / std::tan(halfFov), kLeastHeight_m));
}

}  // namespace tellurion::app
