#include "raster/service.h"

#include <fmt/format.h>

#include <algorithm>

#include "raster/near_names.h"
#include "raster/service_discovery.h"
#include "raster/service_url.h"
#include "raster/tms_service.h"
#include "raster/wms_service.h"
#include "raster/wmts_service.h"
#include "raster/worldwind_service.h"
#include "raster/xyz_service.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr int kDeepestLevel = 30;
constexpr int kSmallestTile = 16;
constexpr int kLargestTile = 4096;

/// What of an entry is out of range, before anything is asked.
io::Result<void> checkNumbers(const ServiceLayer& entry) {
  const int first = entry.minLevel.value_or(0);
  const int last = entry.maxLevel.value_or(std::max(first, 0));
  if (first < 0 || last < first || last > kDeepestLevel) {
    return io::fail(Code::invalidArgument,
                    fmt::format("min_level = {} and max_level = {} are not within 0 to {} in this order", first, last,
                                kDeepestLevel));
  }
  const int pixels = entry.tilePixels.value_or(256);
  if (pixels < kSmallestTile || pixels > kLargestTile) {
    return io::fail(Code::invalidArgument,
                    fmt::format("tile_pixels = {} is not within {} to {}", pixels, kSmallestTile, kLargestTile));
  }
  if (!entry.bounds_degrees) return {};
  const auto& [west, south, east, north] = *entry.bounds_degrees;
  if (!(south < north) || !(south >= -90.0) || !(north <= 90.0) || !(west >= -540.0 && west <= 540.0) ||
      !(east >= -540.0 && east <= 540.0) || west == east) {
    return io::fail(Code::invalidArgument,
                    "bounds are [west, south, east, north] in degrees, south below north; west beyond east crosses the "
                    "date line");
  }
  return {};
}

/// What the entry states goes before what the configuration does.
ServiceLayer overlaid(const ServiceLayer& configured, const ServiceLayer& entry) {
  ServiceLayer merged = entry;
  merged.source = configured.source;
  merged.type = configured.type;
  merged.layer = configured.layer;
  for (auto field : {&ServiceLayer::style, &ServiceLayer::format, &ServiceLayer::version})
    if ((merged.*field).empty()) merged.*field = configured.*field;
  if (!merged.nodata) merged.nodata = configured.nodata;
  if (!merged.levelZero_degrees) merged.levelZero_degrees = configured.levelZero_degrees;
  if (!merged.tilePixels) merged.tilePixels = configured.tilePixels;
  if (!merged.maxLevel) merged.maxLevel = configured.maxLevel;
  if (!merged.bounds_degrees) merged.bounds_degrees = configured.bounds_degrees;
  return merged;
}

io::Result<ServiceLayer> fromConfiguration(const std::vector<WorldWindLayer>& layers, const ServiceLayer& entry,
                                           Kind kind) {
  std::vector<std::string> titles;
  for (const WorldWindLayer& layer : layers)
    if (layer.kind == kind) titles.push_back(layer.title);
  const auto chosen = std::ranges::find_if(layers, [&](const WorldWindLayer& layer) {
    const bool only = entry.layer.empty() && titles.size() == 1;
    return layer.kind == kind && (only || layer.title == entry.layer || layer.entry.layer == entry.layer);
  });
  if (chosen != layers.end()) return overlaid(chosen->entry, entry);
  const std::string what =
      entry.layer.empty() ? std::string(kNameALayer) : fmt::format("there is no layer '{}'", entry.layer);
  return io::fail(Code::notFound,
                  what + fmt::format(" of kind {}", nameOf(kind)) + whatElseThereIs(entry.layer, titles));
}

io::Result<std::string> mapOfService(const std::vector<TileMapReference>& maps, const ServiceLayer& entry) {
  std::vector<std::string> titles;
  for (const TileMapReference& map : maps)
    titles.push_back(map.title);
  const auto chosen = std::ranges::find_if(maps, [&](const TileMapReference& map) {
    return (entry.layer.empty() && maps.size() == 1) || map.title == entry.layer || map.href == entry.layer ||
           (!entry.layer.empty() && map.href.ends_with('/' + entry.layer));
  });
  if (chosen != maps.end()) return chosen->href;
  const std::string what =
      entry.layer.empty() ? std::string(kNameALayer) : fmt::format("there is no layer '{}'", entry.layer);
  return io::fail(Code::notFound, what + whatElseThereIs(entry.layer, titles));
}

io::Result<GridService> openTileMapService(const FoundService& found, const ServiceLayer& entry, Kind kind,
                                           const geo::Body& body, io::Resources& resources) {
  const auto href = mapOfService(std::get<std::vector<TileMapReference>>(found.description), entry);
  if (!href) return tl::unexpected(href.error());
  const std::string url = withCredentialsOf(found.source, resolvedUrl(found.source, *href));
  const auto root = fetchDocument(url, resources);
  if (!root) return tl::unexpected(root.error());
  const auto map = parseTileMap(*root, withoutSecrets(url));
  if (!map) return tl::unexpected(map.error());
  // The document of a map that a service lists lies where its tiles do, whether it is written with a slash or not.
  return tmsService(*map, entry, kind, body, url.ends_with('/') || url.ends_with(".xml") ? url : url + '/');
}

io::Result<GridService> openFound(const FoundService& found, const ServiceLayer& entry, Kind kind,
                                  const geo::Body& body, io::Resources& resources) {
  if (const auto* wms = std::get_if<WmsCapabilities>(&found.description))
    return wmsService(*wms, entry, kind, body, found.source);
  if (const auto* wmts = std::get_if<WmtsCapabilities>(&found.description))
    return wmtsService(*wmts, entry, kind, body, found.source);
  if (const auto* map = std::get_if<TileMap>(&found.description))
    return tmsService(*map, entry, kind, body, found.source);
  if (std::holds_alternative<std::vector<TileMapReference>>(found.description))
    return openTileMapService(found, entry, kind, body, resources);
  if (const auto* layers = std::get_if<std::vector<WorldWindLayer>>(&found.description)) {
    const auto configured = fromConfiguration(*layers, entry, kind);
    if (!configured) return tl::unexpected(configured.error());
    return openService(*configured, kind, body, resources);
  }
  return found.type == "xyz" ? xyzService(entry, kind, body) : worldWindService(entry, kind, body);
}

}  // namespace

io::Result<GridService> openService(const ServiceLayer& layer, Kind kind, const geo::Body& body,
                                    io::Resources& resources) {
  const auto where = [&](io::Failure failure) {
    if (failure.where.empty()) failure.where = withoutSecrets(layer.source);
    return tl::unexpected(std::move(failure));
  };
  if (const auto good = checkNumbers(layer); !good) return where(good.error());
  const auto found = findService(layer, resources);
  if (!found) return where(found.error());
  auto service = openFound(*found, layer, kind, body, resources);
  if (!service) return where(service.error());
  return service;
}

io::Result<GridService> openHeights(const ServiceLayer& layer, const geo::Body& body, io::Resources& resources,
                                    double patience_s) {
  auto service = openService(layer, Kind::elevation, body, resources);
  if (!service || service->overviews == 0 || service->overviews == service->levels.size()) return service;
  const GridLevel& first = service->levels.front();
  const auto image = resources.wait(service->request({0, first.firstColumn, first.firstRow}), patience_s);
  if (image || image.error().code == Code::cancelled) return service;
  ServiceLayer without = layer;
  without.minLevel = 0;
  return openService(without, Kind::elevation, body, resources);
}

}  // namespace tellurion::raster
