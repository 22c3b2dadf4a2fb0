#include "pyramid/map_tiles.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace tellurion::pyramid {
namespace {

constexpr double kCoarser = 1.1;  // as ExportSamples::levelFor

double latitudeOfMercator(double y) {
  // y: 0 at the north edge, 1 at the south edge.
  return geo::Angle::radians(std::atan(std::sinh(geo::kPi * (1.0 - 2.0 * y)))).degrees();
}

/// `at`: tiles from the north edge.
double latitudeAt(MapScheme scheme, int zoom, double at) {
  const double share = at / static_cast<double>(mapRows(scheme, zoom));
  return scheme == MapScheme::mercator ? latitudeOfMercator(share) : 90.0 - 180.0 * share;
}

double longitudeAt(MapScheme scheme, int zoom, double at) {
  return -180.0 + 360.0 * at / static_cast<double>(mapColumns(scheme, zoom));
}

}  // namespace

std::int64_t mapRows(MapScheme /*scheme*/, int zoom) {
  return std::int64_t{1} << zoom;
}

std::int64_t mapColumns(MapScheme scheme, int zoom) {
  return std::int64_t{1} << (scheme == MapScheme::mercator ? zoom : zoom + 1);
}

geo::GeoRect rectOf(MapScheme scheme, const MapTile& tile) {
  const auto x = static_cast<double>(tile.x);
  const auto y = static_cast<double>(tile.y);
  return geo::GeoRect::fromDegrees(latitudeAt(scheme, tile.zoom, y + 1.0), longitudeAt(scheme, tile.zoom, x),
                                   latitudeAt(scheme, tile.zoom, y), longitudeAt(scheme, tile.zoom, x + 1.0));
}

double pixelStep_degrees(MapScheme scheme, int zoom) {
  return 360.0 / (kMapTilePixels * static_cast<double>(mapColumns(scheme, zoom)));
}

int zoomFor(MapScheme scheme, double spacing_degrees) {
  int zoom = 0;
  while (zoom < kMostZoom && pixelStep_degrees(scheme, zoom) > kCoarser * spacing_degrees)
    ++zoom;
  return zoom;
}

PlaceGrid pixelsOf(MapScheme scheme, const MapTile& tile) {
  PlaceGrid grid;
  const double step = pixelStep_degrees(scheme, tile.zoom);
  for (int i = 0; i < kMapTilePixels; ++i) {
    const double share = (i + 0.5) / kMapTilePixels;
    const double latitude = latitudeAt(scheme, tile.zoom, static_cast<double>(tile.y) + share);
    const double narrowing = scheme == MapScheme::mercator ? std::cos(geo::Angle::degrees(latitude).radians()) : 1.0;
    grid.longitudes_degrees.push_back(longitudeAt(scheme, tile.zoom, static_cast<double>(tile.x) + share));
    grid.latitudes_degrees.push_back(latitude);
    grid.steps_degrees.push_back(step * narrowing);
  }
  return grid;
}

MapWalk::MapWalk(const MapExtent& extent) : extent_(extent) {
  const auto covered = std::make_shared<const std::vector<CoveredRect>>(extent.covered);
  for (std::int64_t x = mapColumns(extent.scheme, 0); x-- > 0;)
    waiting_.push_back({.tile = {.zoom = 0, .x = x, .y = 0}, .covered = covered});
}

std::optional<MapStep> MapWalk::next() {
  while (!waiting_.empty()) {
    const MapStep step = std::move(waiting_.back());
    waiting_.pop_back();
    const geo::GeoRect rect = rectOf(extent_.scheme, step.tile);
    if (extent_.region && !extent_.region->intersects(rect)) continue;
    std::vector<CoveredRect> touched;
    std::ranges::copy_if(*step.covered, std::back_inserter(touched),
                         [&](const CoveredRect& c) { return c.rect.intersects(rect); });
    if (touched.empty()) continue;
    const auto covered = std::make_shared<const std::vector<CoveredRect>>(std::move(touched));
    const MapTile& tile = step.tile;
    for (int q = 3; q >= 0 && tile.zoom < extent_.maxZoom; --q) {
      waiting_.push_back(
          {.tile = {.zoom = tile.zoom + 1, .x = 2 * tile.x + (q & 1), .y = 2 * tile.y + (q >> 1)}, .covered = covered});
    }
    if (tile.zoom >= extent_.minZoom) return MapStep{.tile = tile, .covered = covered};
  }
  return std::nullopt;
}

std::uint64_t countOf(const MapExtent& extent, std::uint64_t most, const std::stop_token& stop) {
  MapWalk walk(extent);
  std::uint64_t count = 0;
  while (count < most && !stop.stop_requested() && walk.next())
    ++count;
  return count;
}

}  // namespace tellurion::pyramid
