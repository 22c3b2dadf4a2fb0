#include "raster/wmts_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "raster/doubling_grid.h"
#include "raster/map_reference.h"
#include "raster/near_names.h"
#include "raster/service_entry.h"
#include "raster/service_url.h"
#include "raster/time_extent.h"
#include "raster/url_template.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

io::Result<const WmtsLayer*> findLayer(const WmtsCapabilities& capabilities, const std::string& wanted) {
  if (wanted.empty() && capabilities.layers.size() == 1) return capabilities.layers.data();
  const std::vector<std::string> names = namesOf(capabilities.layers);
  if (wanted.empty()) return io::fail(Code::invalidArgument, std::string(kNameALayer) + whatElseThereIs("", names));
  if (const WmtsLayer* layer = capabilities.layer(wanted)) return layer;
  return io::fail(Code::notFound, fmt::format("there is no layer '{}'{}", wanted, whatElseThereIs(wanted, names)));
}

io::Result<std::string> chooseStyle(const WmtsLayer& layer, const std::string& wanted) {
  const std::vector<std::string> names = namesOf(layer.styles);
  if (wanted.empty()) {
    const auto usual = std::ranges::find(layer.styles, true, &WmtsStyle::isDefault);
    if (usual != layer.styles.end()) return usual->name;
    return names.empty() ? std::string("default") : names[0];
  }
  if (std::ranges::find(names, wanted) != names.end()) return wanted;
  return io::fail(Code::notFound,
                  fmt::format("layer '{}' has no style '{}'{}", layer.name, wanted, whatElseThereIs(wanted, names)));
}

struct ChosenSet {
  const WmtsMatrixSet* set = nullptr;
  const WmtsLink* link = nullptr;
  MapReference reference;
};

/// Lower is better.
int rankOf(const MapReference& reference) {
  switch (reference.plane.kind) {
    case MapPlane::Kind::lonLat:
      return 0;
    case MapPlane::Kind::webMercator:
      return 1;
    case MapPlane::Kind::other:
      return 2;
  }
  return 2;
}

io::Result<ChosenSet> chooseSet(const WmtsCapabilities& capabilities, const WmtsLayer& layer, const ServiceLayer& entry,
                                const geo::Body& body) {
  constexpr int kMostTried = 50;  // each unknown reference costs milliseconds
  int tried = 0;
  std::optional<ChosenSet> best;
  std::vector<std::string> names;
  for (const WmtsLink& link : layer.links) {
    const WmtsMatrixSet* set = capabilities.matrixSet(link.matrixSet);
    if (set == nullptr || set->matrices.empty()) continue;
    names.push_back(set->name);
    if (!entry.matrixSet.empty() && entry.matrixSet != set->name) continue;
    if (!entry.crs.empty() && referenceName(entry.crs) != referenceName(set->crs)) continue;
    const std::string name = referenceName(set->crs);
    const bool isCommon = name == "EPSG:3857" || name == "EPSG:4326" || name == "CRS:84";
    if (!isCommon && ++tried > kMostTried) continue;
    auto reference = mapReference(set->crs, body);
    if (!reference) continue;
    if (!best || rankOf(*reference) < rankOf(best->reference)) best = ChosenSet{set, &link, *reference};
  }
  if (best) return *best;
  const std::string wanted = entry.matrixSet.empty() ? entry.crs : entry.matrixSet;
  return io::fail(Code::notFound,
                  fmt::format("layer '{}' has no tile matrix set {}{}", layer.name,
                              wanted.empty() ? "in a coordinate reference that is known here" : "'" + wanted + "'",
                              whatElseThereIs(wanted, names)));
}

using Dimensions = std::map<std::string, std::string>;  // by name in lower case

io::Result<Dimensions> chooseDimensions(const WmtsLayer& layer, const std::string& time) {
  Dimensions chosen;
  for (const WmtsDimension& dimension : layer.dimensions) {
    const std::string last = dimension.values.empty() ? "" : dimension.values.back();
    chosen[lowered(dimension.name)] = dimension.defaultValue.empty() ? last : dimension.defaultValue;
  }
  if (time.empty()) return chosen;
  const WmtsDimension* dimension = layer.dimension("time");
  if (dimension == nullptr) return io::fail(Code::notFound, fmt::format("layer '{}' has no times", layer.name));
  const auto extent = parseTimeExtent(fmt::format("{}", fmt::join(dimension->values, ",")));
  const bool named = std::ranges::find(dimension->values, time) != dimension->values.end();
  if (!named && !extent.empty() && !offersTime(extent, time)) {
    return io::fail(Code::notFound,
                    fmt::format("layer '{}' has no time {}; it has {}", layer.name, time, describeTimes(extent)));
  }
  chosen["time"] = time;
  return chosen;
}

/// The outer corner of the first tile in the plane: x, y.
std::array<double, 2> cornerOf(const WmtsMatrix& matrix, const MapReference& reference) {
  const auto& [first, second] = matrix.topLeft;
  // Some servers take the axes in the wrong order; a latitude beyond a pole gives it away.
  const bool degrees = reference.plane.kind == MapPlane::Kind::lonLat;
  const bool swapped = degrees && std::abs(reference.northFirst ? first : second) > 90.0 + 1e-9;
  const bool northFirst = reference.northFirst != swapped;
  const double k = reference.planePerUnit;
  return northFirst ? std::array{second * k, first * k} : std::array{first * k, second * k};
}

GridLevel levelOf(const WmtsMatrix& matrix, const MapReference& reference) {
  const std::array<double, 2> corner = cornerOf(matrix, reference);
  GridLevel level;
  level.left = corner[0];
  level.top = corner[1];
  level.pixelWidth = level.pixelHeight =
      matrix.scaleDenominator * kStandardPixel_m / reference.metresPerUnit * reference.planePerUnit;
  level.imageWidth = matrix.tileWidth;
  level.imageHeight = matrix.tileHeight;
  level.endColumn = level.columns = matrix.width;
  level.endRow = level.rows = matrix.height;
  return level;
}

bool keepLimits(const WmtsLink& link, const std::string& matrix, GridLevel& level) {
  const auto limits = std::ranges::find(link.limits, matrix, &WmtsLimits::matrix);
  if (limits == link.limits.end()) return true;
  level.firstColumn = std::clamp<std::int64_t>(limits->minColumn, 0, level.columns);
  level.endColumn = std::clamp<std::int64_t>(limits->maxColumn, -1, level.columns - 1) + 1;
  level.firstRow = std::clamp<std::int64_t>(limits->minRow, 0, level.rows);
  level.endRow = std::clamp<std::int64_t>(limits->maxRow, -1, level.rows - 1) + 1;
  return level.firstColumn < level.endColumn && level.firstRow < level.endRow;
}

/// Everything that a request needs but the image's place.
struct Plan {
  std::string keyValueUrl;  ///< empty: by the template
  UrlTemplate url{""};
  Dimensions values;                  ///< of the template: style, matrix set, dimensions
  std::vector<std::string> matrices;  ///< names, by level
  std::vector<GridLevel> levels;
  std::string dataset;
  Kind kind = Kind::imagery;
  int rawSampleBytes = 0;
};

std::string urlOf(const Plan& plan, const GridImageId& id) {
  const std::string& matrix = plan.matrices[static_cast<std::size_t>(id.level)];
  if (!plan.keyValueUrl.empty()) {
    return fmt::format("{}&TILEMATRIX={}&TILEROW={}&TILECOL={}", plan.keyValueUrl, percentEncoded(matrix, ",:/"),
                       id.row, id.column);
  }
  return plan.url.filled([&](std::string_view name) {
    if (name == "tilematrix") return percentEncoded(matrix, ":");
    if (name == "tilerow") return std::to_string(id.row);
    if (name == "tilecol") return std::to_string(id.column);
    return percentEncoded(plan.values.at(std::string(name)), ":,");
  });
}

/// By the template of the format, else by keys and values. False: neither can be.
bool chooseUrl(const WmtsCapabilities& capabilities, const WmtsLayer& layer, const std::string& format,
               const std::string& source, Plan& plan) {
  for (const WmtsTemplate& offered : layer.templates) {
    UrlTemplate url(withCredentialsOf(source, resolvedUrl(source, offered.url)));
    const bool known = std::ranges::all_of(url.names(), [&](const std::string& name) {
      return name == "tilematrix" || name == "tilerow" || name == "tilecol" || plan.values.contains(name);
    });
    if (offered.format != format || !known || !url.has("tilerow") || !url.has("tilecol")) continue;
    plan.url = std::move(url);
    return true;
  }
  const std::string base = capabilities.getTileUrl.empty() ? source : resolvedUrl(source, capabilities.getTileUrl);
  if (localPath(base)) return false;
  QueryItems items = {{"SERVICE", "WMTS"},
                      {"REQUEST", "GetTile"},
                      {"VERSION", "1.0.0"},
                      {"LAYER", layer.name},
                      {"STYLE", plan.values.at("style")},
                      {"FORMAT", format},
                      {"TILEMATRIXSET", plan.values.at("tilematrixset")}};
  for (const WmtsDimension& dimension : layer.dimensions)
    items.emplace_back(dimension.name, plan.values.at(lowered(dimension.name)));
  plan.keyValueUrl = withQuery(withCredentialsOf(source, base), items);
  return true;
}

std::vector<std::string> formatsOf(const WmtsLayer& layer) {
  std::vector<std::string> formats = layer.formats;
  for (const WmtsTemplate& offered : layer.templates)
    if (std::ranges::find(formats, offered.format) == formats.end()) formats.push_back(offered.format);
  return formats;
}

void addLevels(const ChosenSet& chosen, const ServiceLayer& entry, const std::optional<PlaneBox>& box, Plan& plan) {
  std::vector<const WmtsMatrix*> matrices;
  for (const WmtsMatrix& matrix : chosen.set->matrices)
    matrices.push_back(&matrix);
  std::ranges::stable_sort(matrices, std::ranges::greater{}, &WmtsMatrix::scaleDenominator);
  const int end = std::min(entry.maxLevel.value_or(1000), static_cast<int>(matrices.size()) - 1);
  for (int i = entry.minLevel.value_or(0); i <= end; ++i) {
    const WmtsMatrix& matrix = *matrices[static_cast<std::size_t>(i)];
    GridLevel level = levelOf(matrix, chosen.reference);
    if (!keepLimits(*chosen.link, matrix.name, level) || (box && !limitTo(*box, level))) continue;
    plan.levels.push_back(level);
    plan.matrices.push_back(matrix.name);
  }
}

}  // namespace

io::Result<GridService> wmtsService(const WmtsCapabilities& capabilities, const ServiceLayer& entry, Kind kind,
                                    const geo::Body& body, const std::string& source) {
  const auto layer = findLayer(capabilities, entry.layer);
  if (!layer) return tl::unexpected(layer.error());
  const auto style = chooseStyle(**layer, entry.style);
  if (!style) return tl::unexpected(style.error());
  const auto format = chooseFormat(entry, kind, formatsOf(**layer));
  if (!format) return tl::unexpected(format.error());
  const auto dimensions = chooseDimensions(**layer, entry.time);
  if (!dimensions) return tl::unexpected(dimensions.error());
  const auto chosen = chooseSet(capabilities, **layer, entry, body);
  if (!chosen) return tl::unexpected(chosen.error());
  auto heights = heightEncoding(entry);
  if (!heights) return tl::unexpected(heights.error());

  Plan plan;
  plan.values = *dimensions;
  plan.values["style"] = *style;
  plan.values["tilematrixset"] = chosen->set->name;
  plan.values["layer"] = (*layer)->name;
  plan.kind = kind;
  plan.rawSampleBytes = rawSampleBytes(*format);
  if (!chooseUrl(capabilities, **layer, *format, source, plan)) {
    return io::fail(Code::unsupported,
                    fmt::format("the capabilities do not say where tiles of layer '{}' are", (*layer)->name));
  }

  GridService service;
  service.kind = kind;
  service.body = body;
  service.plane = chosen->reference.plane;
  service.bounds = boundsOf(entry, (*layer)->lonLatBox_degrees);
  service.heights = *heights;
  if (const WmtsDimension* time = (*layer)->dimension("time"))
    service.times = parseTimeExtent(fmt::format("{}", fmt::join(time->values, ",")));
  service.attribution = entry.attribution.empty() ? capabilities.attribution : entry.attribution;
  service.name =
      fmt::format("{} {} {} {}", withoutSecrets(withoutQuery(source)), (*layer)->name, *style, chosen->set->name);
  for (const auto& [name, value] : *dimensions)
    service.name += ' ' + value;
  addLevels(*chosen, entry, planeBox(service.plane, service.bounds, body), plan);
  if (plan.levels.empty()) {
    return io::fail(Code::unsupported, fmt::format("layer '{}' has no tiles in set '{}' within its box and min_level, "
                                                   "max_level",
                                                   (*layer)->name, chosen->set->name));
  }
  service.levels = plan.levels;
  plan.dataset = service.name;
  service.request = [shared = std::make_shared<const Plan>(std::move(plan))](const GridImageId& id) {
    const GridLevel& level = shared->levels[static_cast<std::size_t>(id.level)];
    return imageRequest(urlOf(*shared, id), shared->dataset,
                        {shared->kind, level.imageWidth, level.imageHeight, shared->rawSampleBytes, true});
  };
  return service;
}

}  // namespace tellurion::raster
