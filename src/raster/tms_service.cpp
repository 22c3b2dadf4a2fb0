#include "raster/tms_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "raster/doubling_grid.h"
#include "raster/grid_geometry.h"
#include "raster/map_reference.h"
#include "raster/parse_number.h"
#include "raster/service_entry.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

std::optional<std::array<double, 4>> boxOf(const XmlElement& root) {
  const XmlElement* box = root.child("BoundingBox");
  if (box == nullptr) return std::nullopt;
  std::array<double, 4> values{};
  constexpr std::array kNames = {"minx", "miny", "maxx", "maxy"};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parseNumber<double>(box->attribute(kNames[i]));
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return values[0] < values[2] && values[1] < values[3] ? std::optional(values) : std::nullopt;
}

void readLevels(const XmlElement& root, std::vector<TmsLevel>& levels) {
  const XmlElement* sets = root.child("TileSets");
  if (sets == nullptr) return;
  for (const XmlElement* set : sets->all("TileSet")) {
    const auto units = parseNumber<double>(set->attribute("units-per-pixel"));
    const auto order = parseNumber<int>(set->attribute("order"));
    if (!units || *units <= 0.0) continue;
    levels.push_back({std::string(set->attribute("href")), *units, order.value_or(static_cast<int>(levels.size()))});
  }
  std::ranges::stable_sort(levels, std::ranges::greater{}, &TmsLevel::unitsPerPixel);
}

/// The stated box in the plane. Some writers state a Mercator map's box in degrees, or latitude first: such a box says
/// nothing here, and only the origin counts.
std::optional<PlaneBox> statedBox(const TileMap& map, const MapReference& reference) {
  if (!map.box) return std::nullopt;
  const auto& [minX, minY, maxX, maxY] = *map.box;
  constexpr double kSlack = 1e-6;
  const double largest = std::max({std::abs(minX), std::abs(minY), std::abs(maxX), std::abs(maxY)});
  if (reference.plane.kind == MapPlane::Kind::webMercator && largest <= 360.0) return std::nullopt;
  if (reference.plane.kind == MapPlane::Kind::lonLat && (minY < -90.0 - kSlack || maxY > 90.0 + kSlack))
    return std::nullopt;
  const double k = reference.planePerUnit;
  return PlaneBox{minX * k, minY * k, maxX * k, maxY * k};
}

/// How far the tiles of a map reach that does not say so.
PlaneBox farthest(const MapReference& reference, const PlaneBox& within) {
  const double k = reference.planePerUnit;
  constexpr double kMercatorHalf_m = geo::kPi * 6378137.0;
  switch (reference.plane.kind) {
    case MapPlane::Kind::lonLat:
      return {-180.0, -90.0, 180.0, 90.0};
    case MapPlane::Kind::webMercator:
      return {-kMercatorHalf_m * k, -kMercatorHalf_m * k, kMercatorHalf_m * k, kMercatorHalf_m * k};
    case MapPlane::Kind::other:
      break;
  }
  return within;
}

GridLevel levelOf(const TileMap& map, const TmsLevel& tms, const MapReference& reference, const PlaneBox& reach) {
  const double k = reference.planePerUnit;
  GridLevel level;
  level.pixelWidth = level.pixelHeight = tms.unitsPerPixel * k;
  level.imageWidth = map.tileWidth;
  level.imageHeight = map.tileHeight;
  level.left = map.origin[0] * k;
  const auto count = [](double extent, double side) {
    constexpr double kAlmost = 1e-6;  // of a tile: what rounding adds to the last one
    constexpr double kMostTiles = 1e12;
    return static_cast<std::int64_t>(std::clamp(std::ceil(extent / side - kAlmost), 1.0, kMostTiles));
  };
  const double height = level.pixelHeight * map.tileHeight;
  level.endColumn = level.columns = count(reach.right - level.left, level.pixelWidth * map.tileWidth);
  level.endRow = level.rows = count(reach.top - map.origin[1] * k, height);
  level.top = map.origin[1] * k + static_cast<double>(level.rows) * height;
  return level;
}

struct Plan {
  std::vector<std::string> folders;  ///< of the levels, with a slash at the end
  std::vector<GridLevel> levels;
  std::string query;  ///< of the source, with its question mark: a token
  std::string extension;
  std::string dataset;
  ExpectedImage expected;
};

io::ResourceRequest requestFor(const Plan& plan, const GridImageId& id) {
  const auto level = static_cast<std::size_t>(id.level);
  return imageRequest(fmt::format("{}{}/{}.{}{}", plan.folders[level], id.column, plan.levels[level].rows - 1 - id.row,
                                  plan.extension, plan.query),
                      plan.dataset, plan.expected);
}

std::string folderOf(const std::string& source, const TmsLevel& level) {
  std::string folder = resolvedUrl(source, level.href.empty() ? std::to_string(level.order) : level.href);
  if (!folder.ends_with('/')) folder += '/';
  return folder;
}

}  // namespace

io::Result<TileMap> parseTileMap(const XmlElement& root, const std::string& where) {
  if (root.name != "TileMap") {
    return io::fail(Code::corrupt, fmt::format("no tile map: the document is a <{}>", root.name.substr(0, 80)), where);
  }
  TileMap map;
  map.title = onOneLine(root.textOf("Title"));
  map.abstract = root.textOf("Abstract");
  map.crs = root.textOf("SRS");
  map.box = boxOf(root);
  const XmlElement* origin = root.child("Origin");
  const auto x = origin != nullptr ? parseNumber<double>(origin->attribute("x")) : std::nullopt;
  const auto y = origin != nullptr ? parseNumber<double>(origin->attribute("y")) : std::nullopt;
  const XmlElement* format = root.child("TileFormat");
  if (!x || !y || format == nullptr)
    return io::fail(Code::corrupt, "the tile map states no origin or no tile format", where);
  map.origin = {*x, *y};
  map.tileWidth = parseNumber<int>(format->attribute("width")).value_or(256);
  map.tileHeight = parseNumber<int>(format->attribute("height")).value_or(256);
  map.format = format->attribute("mime-type");
  map.extension = format->attribute("extension");
  if (map.extension.empty()) map.extension = extensionOf(map.format);
  readLevels(root, map.levels);
  const auto inside = [](int side) { return side >= 1 && side <= kMaxImageSide; };
  if (map.levels.empty() || !inside(map.tileWidth) || !inside(map.tileHeight))
    return io::fail(Code::corrupt, "the tile map has no level with a resolution, or tiles of an impossible size",
                    where);
  return map;
}

io::Result<std::vector<TileMapReference>> parseTileMapService(const XmlElement& root, const std::string& where) {
  constexpr std::size_t kMostMaps = 20'000;
  std::vector<TileMapReference> maps;
  const XmlElement* list = root.name == "TileMapService" ? root.child("TileMaps") : nullptr;
  if (list == nullptr) return maps;
  for (const XmlElement* map : list->all("TileMap")) {
    if (maps.size() == kMostMaps)
      return io::fail(Code::unsupported, fmt::format("the service lists more than {} tile maps", kMostMaps), where);
    maps.push_back(
        {onOneLine(map->attribute("title")), std::string(map->attribute("srs")), std::string(map->attribute("href"))});
  }
  return maps;
}

io::Result<GridService> tmsService(const TileMap& map, const ServiceLayer& entry, Kind kind, const geo::Body& body,
                                   const std::string& source) {
  const auto reference = mapReference(map.crs, body);
  if (!reference) return tl::unexpected(reference.error());
  auto heights = heightEncoding(entry);
  if (!heights) return tl::unexpected(heights.error());
  GridService service;
  service.name = withoutSecrets(withoutQuery(source));
  service.kind = kind;
  service.body = body;
  service.plane = reference->plane;
  service.heights = *heights;
  service.attribution = entry.attribution;
  const auto stated = statedBox(map, *reference);
  std::optional<std::array<double, 4>> degrees;
  if (stated && service.plane.kind == MapPlane::Kind::lonLat)
    degrees = {stated->left, stated->bottom, stated->right, stated->top};
  service.bounds = boundsOf(entry, degrees);
  const auto asked = planeBox(service.plane, service.bounds, body);
  if (!asked) return io::fail(Code::unsupported, "the bounds are nowhere in " + map.crs);
  const PlaneBox reach = stated.value_or(farthest(*reference, *asked));

  Plan plan;
  plan.extension = map.extension;
  plan.dataset = service.name;
  plan.expected = {kind, map.tileWidth, map.tileHeight, rawSampleBytes(map.format), true};
  const std::size_t question = source.find('?');
  if (question != source.npos) plan.query = source.substr(question);
  for (const TmsLevel& tms : map.levels) {
    if (tms.order < entry.minLevel.value_or(0) || tms.order > entry.maxLevel.value_or(1000)) continue;
    GridLevel level = levelOf(map, tms, *reference, reach);
    if (!limitTo(reach, level) || !limitTo(*asked, level)) continue;
    plan.levels.push_back(level);
    plan.folders.push_back(folderOf(source, tms));
  }
  if (plan.levels.empty())
    return io::fail(Code::unsupported, "the tile map has no tiles within the bounds and min_level, max_level");
  service.levels = plan.levels;
  service.request = [shared = std::make_shared<const Plan>(std::move(plan))](const GridImageId& id) {
    return requestFor(*shared, id);
  };
  return service;
}

}  // namespace tellurion::raster
