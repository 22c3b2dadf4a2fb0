#include "raster/wms_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <memory>

#include "raster/doubling_grid.h"
#include "raster/map_reference.h"
#include "raster/near_names.h"
#include "raster/service_entry.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

using Code = io::Failure::Code;

constexpr int kImagePixels = 512;
constexpr int kFinestLevel = 22;   // a pixel of 9 mm on the Earth
constexpr int kMostPixels = 4096;  // a side

std::vector<std::string> partsOf(std::string_view list) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t comma = list.find(',');
    parts.emplace_back(list.substr(0, comma));
    if (comma == list.npos) return parts;
    list = list.substr(comma + 1);
  }
}

/// What is drawn: one layer, or several as if they were one.
struct Drawn {
  std::string layers;
  WmsLayer merged;  ///< box of all; references, dimensions and styles of the first
  std::vector<WmsLayer> each;
};

void unite(const WmsLayer& other, WmsLayer& merged) {
  merged.noSubsets = merged.noSubsets || other.noSubsets;
  if (merged.fixedWidth == 0) merged.fixedWidth = other.fixedWidth;
  if (merged.fixedHeight == 0) merged.fixedHeight = other.fixedHeight;
  if (!merged.lonLatBox_degrees || !other.lonLatBox_degrees) {
    merged.lonLatBox_degrees.reset();
    return;
  }
  auto& box = *merged.lonLatBox_degrees;
  const auto& more = *other.lonLatBox_degrees;
  box = {std::min(box[0], more[0]), std::min(box[1], more[1]), std::max(box[2], more[2]), std::max(box[3], more[3])};
}

io::Result<Drawn> findLayers(const WmsCapabilities& capabilities, const std::string& wanted) {
  const std::vector<std::string> names = namesOf(capabilities.layers);
  if (wanted.empty() && names.size() != 1)
    return io::fail(Code::invalidArgument, std::string(kNameALayer) + whatElseThereIs("", names));
  Drawn drawn;
  drawn.layers = wanted.empty() ? names[0] : wanted;
  const bool isOne = capabilities.layer(drawn.layers) != nullptr;
  for (const std::string& name : isOne ? std::vector{drawn.layers} : partsOf(drawn.layers)) {
    const WmsLayer* layer = name.empty() ? nullptr : capabilities.layer(name);
    if (layer == nullptr)
      return io::fail(Code::notFound, fmt::format("there is no layer '{}'{}", name, whatElseThereIs(name, names)));
    drawn.each.push_back(capabilities.withInherited(*layer));
  }
  if (capabilities.layerLimit > 0 && drawn.each.size() > static_cast<std::size_t>(capabilities.layerLimit)) {
    return io::fail(Code::unsupported,
                    fmt::format("the server draws at most {} layers at once", capabilities.layerLimit));
  }
  drawn.merged = drawn.each[0];
  for (std::size_t i = 1; i < drawn.each.size(); ++i)
    unite(drawn.each[i], drawn.merged);
  return drawn;
}

/// The names for STYLES, one a layer.
io::Result<std::string> stylesFor(const Drawn& drawn, const std::string& wanted) {
  std::vector<std::string> styles = wanted.empty() ? std::vector<std::string>{} : partsOf(wanted);
  styles.resize(drawn.each.size());
  for (std::size_t i = 0; i < styles.size(); ++i) {
    const std::vector<std::string> names = namesOf(drawn.each[i].styles);
    const bool isDefault = styles[i].empty() || styles[i] == "default";  // 1.1.1 and 1.3.0: '' is the default style
    if (isDefault || std::ranges::find(names, styles[i]) != names.end()) continue;
    return io::fail(Code::notFound, fmt::format("layer '{}' has no style '{}'{}", drawn.each[i].name, styles[i],
                                                whatElseThereIs(styles[i], names)));
  }
  return fmt::format("{}", fmt::join(styles, ","));
}

/// How the server writes it, and what it is.
struct ChosenReference {
  std::string asWritten;
  MapReference reference;
};

io::Result<ChosenReference> chooseReference(const WmsLayer& layer, const ServiceLayer& entry, const geo::Body& body,
                                            const std::string& version) {
  const std::vector<std::string> offered = layer.crs.empty() ? std::vector<std::string>{"EPSG:4326"} : layer.crs;
  const auto named = [&](std::string_view name) {
    return std::ranges::find_if(offered, [&](const std::string& crs) { return referenceName(crs) == name; });
  };
  const auto taken = [&](const std::string& crs) -> io::Result<ChosenReference> {
    auto reference = mapReference(crs, body);
    if (!reference) return tl::unexpected(reference.error());
    return ChosenReference{crs, *reference};
  };
  if (!entry.crs.empty()) {
    const auto found = named(referenceName(entry.crs));
    if (found != offered.end()) return taken(*found);
    return io::fail(Code::notFound, fmt::format("layer '{}' is not offered in '{}'{}", layer.name, entry.crs,
                                                whatElseThereIs(entry.crs, offered)));
  }
  // CRS:84 came with 1.3.0, where no server can mistake the order of its axes; before, servers list it and refuse it.
  const bool knows84 = version == "1.3.0";
  for (const char* preferred : {knows84 ? "CRS:84" : "EPSG:4326", knows84 ? "EPSG:4326" : "CRS:84", "EPSG:3857"})
    if (const auto found = named(preferred); found != offered.end()) return taken(*found);
  constexpr std::size_t kMostTried = 50;
  for (std::size_t i = 0; i < std::min(offered.size(), kMostTried); ++i)
    if (auto reference = taken(offered[i])) return reference;
  return io::fail(Code::unsupported, fmt::format("layer '{}' is in no coordinate reference that is known here{}",
                                                 layer.name, whatElseThereIs("", offered)));
}

/// TIME and its like.
io::Result<QueryItems> dimensionItems(const WmsLayer& layer, const ServiceLayer& entry) {
  QueryItems items;
  if (!entry.time.empty() && layer.dimension("time") == nullptr)
    return io::fail(Code::notFound, fmt::format("layer '{}' has no times", layer.name));
  for (const WmsDimension& dimension : layer.dimensions) {
    if (dimension.name == "time") {
      const auto extent = parseTimeExtent(dimension.values);
      if (!entry.time.empty() && !dimension.nearestValue && !extent.empty() && !offersTime(extent, entry.time)) {
        return io::fail(Code::notFound, fmt::format("layer '{}' has no time {}; it has {}", layer.name, entry.time,
                                                    describeTimes(extent)));
      }
      const std::string time = entry.time.empty() && dimension.defaultValue.empty() ? lastTime(extent) : entry.time;
      if (!time.empty()) items.emplace_back("TIME", time);
    } else if (dimension.defaultValue.empty() && !dimension.values.empty()) {
      const auto first = parseTimeExtent(dimension.values);
      if (first.empty()) continue;
      items.emplace_back(dimension.name == "elevation" ? "ELEVATION" : "DIM_" + dimension.name, first[0].start);
    }
  }
  return items;
}

io::Result<std::string> chooseVersion(const WmsCapabilities& capabilities, const ServiceLayer& entry) {
  const std::string version = entry.version.empty() ? capabilities.version : entry.version;
  for (const char* known : {"1.1.0", "1.1.1", "1.3.0"})
    if (version == known) return version;
  return io::fail(Code::unsupported,
                  fmt::format("maps are asked for in WMS 1.1.0, 1.1.1 and 1.3.0, not in '{}'", version.substr(0, 20)));
}

/// The box of what is asked for in the plane: the server's own in this reference when there is one, else projected.
std::optional<PlaneBox> layerBox(const WmsLayer& layer, const ChosenReference& chosen, bool northFirst,
                                 const GridService& service, bool ownBounds) {
  // Of a map that is given whole, the box is the map's, and so to the last digit.
  if (layer.noSubsets || (!ownBounds && service.plane.kind == MapPlane::Kind::other)) {
    for (const WmsBox& box : layer.boxes) {
      if (referenceName(box.crs) != chosen.reference.name) continue;
      const double scale = chosen.reference.planePerUnit;
      const auto& [a, b, c, d] = box.values;
      return northFirst ? PlaneBox{b * scale, a * scale, d * scale, c * scale}
                        : PlaneBox{a * scale, b * scale, c * scale, d * scale};
    }
  }
  if (layer.noSubsets && layer.lonLatBox_degrees && service.plane.kind == MapPlane::Kind::lonLat) {
    const auto& [west, south, east, north] = *layer.lonLatBox_degrees;
    return PlaneBox{west, south, east, north};
  }
  return planeBox(service.plane, service.bounds, service.body);
}

struct ImagePixels {
  int width = 0;
  int height = 0;
};

/// Of images in a grid.
ImagePixels gridPixels(const WmsCapabilities& capabilities, const WmsLayer& layer, const ServiceLayer& entry) {
  int pixels = entry.tilePixels.value_or(kImagePixels);
  for (const int most : {capabilities.maxWidth, capabilities.maxHeight})
    if (most > 0 && most < pixels) pixels = static_cast<int>(std::bit_floor(static_cast<unsigned>(most)));
  return {layer.fixedWidth > 0 ? layer.fixedWidth : pixels, layer.fixedHeight > 0 ? layer.fixedHeight : pixels};
}

/// Of the one image of a map that is given whole: the server's size, else as large as may be, in the shape of its box.
ImagePixels wholePixels(const WmsCapabilities& capabilities, const WmsLayer& layer, const ServiceLayer& entry,
                        const PlaneBox& box) {
  const auto most = [&](int ofServer) {
    const int pixels = entry.tilePixels.value_or(kMostPixels);
    return static_cast<double>(ofServer > 0 ? std::min(ofServer, pixels) : pixels);
  };
  const double shape = (box.right - box.left) / (box.top - box.bottom);
  const double width = std::min(most(capabilities.maxWidth), most(capabilities.maxHeight) * shape);
  const auto whole = [](double pixels) { return std::max(1, static_cast<int>(std::floor(pixels + 1e-6))); };
  return {layer.fixedWidth > 0 ? layer.fixedWidth : whole(width),
          layer.fixedHeight > 0 ? layer.fixedHeight : whole(width / shape)};
}

GridLevel wholeLevel(const PlaneBox& box, const ImagePixels& pixels) {
  GridLevel level{.left = box.left,
                  .top = box.top,
                  .pixelWidth = (box.right - box.left) / pixels.width,
                  .pixelHeight = (box.top - box.bottom) / pixels.height,
                  .imageWidth = pixels.width,
                  .imageHeight = pixels.height};
  level.columns = level.endColumn = level.rows = level.endRow = 1;
  return level;
}

/// Whether a layer says that it covers so much of the body that one small map of all of it is worth a request.
bool isWide(const WmsLayer& layer) {
  if (!layer.lonLatBox_degrees) return false;
  const auto& [west, south, east, north] = *layer.lonLatBox_degrees;
  return east - west >= 90.0 && north - south >= 45.0;
}

/// The levels that the scale limits allow and the box touches. Before those of the grid come coarser ones, each one
/// small map of everything, so that there is something to see before the first full images have come.
std::vector<GridLevel> levelsFor(const WmsLayer& layer, const ServiceLayer& entry, const ChosenReference& chosen,
                                 const DoublingGrid& grid, const PlaneBox& box, const ImagePixels& pixels) {
  constexpr double kSlack = 1.0 + 1e-6;
  const auto pixelAt = [&](double denominator) {
    return denominator * kStandardPixel_m / chosen.reference.metresPerUnit * chosen.reference.planePerUnit;
  };
  std::vector<GridLevel> levels;
  if (!entry.minLevel && isWide(layer) && layer.fixedWidth == 0 && layer.fixedHeight == 0 && !layer.maxScaleDenominator)
    levels = overviewLevels(chosen.reference.plane, grid, pixels.width);
  for (int i = entry.minLevel.value_or(0); i <= entry.maxLevel.value_or(kFinestLevel); ++i) {
    GridLevel level = levelOf(grid, i, pixels.width);
    level.pixelHeight *= static_cast<double>(pixels.width) / pixels.height;
    level.imageHeight = pixels.height;
    const bool tooCoarse = layer.maxScaleDenominator && level.pixelWidth > pixelAt(*layer.maxScaleDenominator) * kSlack;
    const bool tooFine = layer.minScaleDenominator && level.pixelWidth * kSlack < pixelAt(*layer.minScaleDenominator);
    if (tooCoarse || (tooFine && !levels.empty())) continue;
    if (limitTo(box, level)) levels.push_back(level);
  }
  return levels;
}

/// Shortest decimal that reads back as the same number, never with an exponent.
std::string plainNumber(double value) {
  std::string text = fmt::format("{}", value + 0.0);
  if (text.find('e') == text.npos) return text;
  text = fmt::format("{:.17f}", value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text == "-0" ? "0" : text;
}

/// Everything that a request needs but the image's place.
struct Plan {
  std::vector<std::string> urls;  ///< of each level, with all but BBOX
  std::string dataset;
  std::vector<GridLevel> levels;
  bool northFirst = false;
  double unitsPerPlane = 1.0;
  std::optional<PlaneBox> whole;  ///< all that is ever asked for
  ExpectedImage expected;         ///< but for its size, which is the level's
};

io::ResourceRequest requestFor(const Plan& plan, const GridImageId& id) {
  const GridLevel& level = plan.levels[static_cast<std::size_t>(id.level)];
  const double width = level.pixelWidth * level.imageWidth;
  const double height = level.pixelHeight * level.imageHeight;
  // From the corner, so that neighbours name their common edge alike.
  const auto x = [&](std::int64_t column) {
    return plainNumber((level.left + static_cast<double>(column) * width) * plan.unitsPerPlane);
  };
  const auto y = [&](std::int64_t row) {
    return plainNumber((level.top - static_cast<double>(row) * height) * plan.unitsPerPlane);
  };
  const auto edge = [&](double at) { return plainNumber(at * plan.unitsPerPlane); };
  const std::string left = x(id.column);
  const std::string right = plan.whole ? edge(plan.whole->right) : x(id.column + 1);
  const std::string top = y(id.row);
  const std::string bottom = plan.whole ? edge(plan.whole->bottom) : y(id.row + 1);
  const std::string box = plan.northFirst ? fmt::format("{},{},{},{}", bottom, left, top, right)
                                          : fmt::format("{},{},{},{}", left, bottom, right, top);
  ExpectedImage expected = plan.expected;
  expected.width = level.imageWidth;
  expected.height = level.imageHeight;
  return imageRequest(plan.urls[static_cast<std::size_t>(id.level)] + "&BBOX=" + box, plan.dataset, expected);
}

QueryItems fixedItems(const std::string& version, const std::string& layers, const std::string& styles,
                      const std::string& crs, const ImagePixels& pixels, const std::string& format, Kind kind) {
  QueryItems items = {{"SERVICE", "WMS"},
                      {"VERSION", version},
                      {"REQUEST", "GetMap"},
                      {"LAYERS", layers},
                      {"STYLES", styles},
                      {version == "1.3.0" ? "CRS" : "SRS", crs},
                      {"WIDTH", std::to_string(pixels.width)},
                      {"HEIGHT", std::to_string(pixels.height)},
                      {"FORMAT", format}};
  const bool canBeTransparent = lowered(format).find("jp") == std::string::npos;
  if (kind == Kind::imagery) items.emplace_back("TRANSPARENT", canBeTransparent ? "TRUE" : "FALSE");
  return items;
}

}  // namespace

io::Result<GridService> wmsService(const WmsCapabilities& capabilities, const ServiceLayer& entry, Kind kind,
                                   const geo::Body& body, const std::string& source) {
  const auto drawn = findLayers(capabilities, entry.layer);
  if (!drawn) return tl::unexpected(drawn.error());
  const auto version = chooseVersion(capabilities, entry);
  if (!version) return tl::unexpected(version.error());
  const auto styles = stylesFor(*drawn, entry.style);
  if (!styles) return tl::unexpected(styles.error());
  const auto format = chooseFormat(entry, kind, capabilities.formats);
  if (!format) return tl::unexpected(format.error());
  const auto chosen = chooseReference(drawn->merged, entry, body, *version);
  if (!chosen) return tl::unexpected(chosen.error());
  const auto dimensions = dimensionItems(drawn->merged, entry);
  if (!dimensions) return tl::unexpected(dimensions.error());
  auto heights = heightEncoding(entry);
  if (!heights) return tl::unexpected(heights.error());

  const std::string advertised = capabilities.getMapUrl.empty() ? source : resolvedUrl(source, capabilities.getMapUrl);

  GridService service;
  service.kind = kind;
  service.body = body;
  service.plane = chosen->reference.plane;
  service.bounds = boundsOf(entry, drawn->merged.lonLatBox_degrees);
  service.heights = *heights;
  if (const WmsDimension* time = drawn->merged.dimension("time")) service.times = parseTimeExtent(time->values);
  service.attribution = entry.attribution.empty() ? drawn->merged.attribution : entry.attribution;
  service.name = fmt::format("{} {}", withoutSecrets(withoutQuery(advertised)), drawn->layers);
  for (const auto& extra : {*styles, dimensions->empty() ? std::string() : dimensions->front().second})
    if (!extra.empty()) service.name += ' ' + extra;

  Plan plan;
  plan.northFirst = *version == "1.3.0" && chosen->reference.northFirst;
  const auto box = layerBox(drawn->merged, *chosen, plan.northFirst, service, entry.bounds_degrees.has_value());
  if (!box) {
    return io::fail(Code::unsupported, fmt::format("the box of layer '{}' is nowhere in {}; ask for another reference "
                                                   "(crs)",
                                                   drawn->layers, chosen->asWritten));
  }
  const bool isWhole = drawn->merged.noSubsets;
  const ImagePixels pixels =
      isWhole ? wholePixels(capabilities, drawn->merged, entry, *box) : gridPixels(capabilities, drawn->merged, entry);
  if (pixels.width > kMostPixels || pixels.height > kMostPixels) {
    return io::fail(Code::unsupported,
                    fmt::format("the server gives layer '{}' as images of {} x {} pixels only; at most {} a side are "
                                "read",
                                drawn->layers, pixels.width, pixels.height, kMostPixels));
  }
  if (isWhole) {
    plan.whole = *box;
    service.levels = plan.levels = {wholeLevel(*box, pixels)};
  } else {
    const DoublingGrid grid = doublingGrid(service.plane, *box, body);
    service.levels = plan.levels = levelsFor(drawn->merged, entry, *chosen, grid, *box, pixels);
    const double own = levelOf(grid, 0, pixels.width).pixelWidth;
    service.overviews = static_cast<std::size_t>(
        std::ranges::count_if(service.levels, [&](const GridLevel& level) { return level.pixelWidth > 1.5 * own; }));
  }
  if (service.levels.empty()) {
    return io::fail(Code::unsupported, fmt::format("layer '{}' has no level within its scale limits, its box and "
                                                   "min_level, max_level",
                                                   drawn->layers));
  }
  for (const GridLevel& level : plan.levels) {
    QueryItems items = fixedItems(*version, drawn->layers, *styles, chosen->asWritten,
                                  {level.imageWidth, level.imageHeight}, *format, kind);
    items.insert(items.end(), dimensions->begin(), dimensions->end());
    plan.urls.push_back(withQuery(withCredentialsOf(source, advertised), items));
  }
  plan.dataset = service.name;
  plan.unitsPerPlane = 1.0 / chosen->reference.planePerUnit;
  plan.expected = {kind, pixels.width, pixels.height, rawSampleBytes(*format), false};
  service.request = [shared = std::make_shared<const Plan>(std::move(plan))](const GridImageId& id) {
    return requestFor(*shared, id);
  };
  return service;
}

}  // namespace tellurion::raster
