#include "raster/wms_capabilities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <unordered_set>

#include "raster/parse_number.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

constexpr double kStandardPixel_m = 0.00028;
constexpr std::size_t kMostLayers = 20'000;
constexpr std::size_t kMostParts = 8'192;  // of one layer

std::vector<std::string> words(std::string_view text) {
  constexpr const char* kSpace = " \t\r\n";
  std::vector<std::string> found;
  for (std::size_t at = text.find_first_not_of(kSpace); at != text.npos; at = text.find_first_not_of(kSpace, at)) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    found.emplace_back(text.substr(at, end - at));
    at = end;
  }
  return found;
}

bool isTrue(std::string_view text) {
  return text == "1" || lowered(text) == "true";
}

void replaceFlag(const XmlElement& element, const char* name, bool& flag) {
  if (const std::string_view value = element.attribute(name); !value.empty()) flag = isTrue(value);
}

void replaceCount(std::string_view text, int& count) {
  if (const auto value = parseNumber<int>(text); value && *value >= 0) count = *value;
}

std::optional<std::array<double, 4>> boxOf(const XmlElement& element, std::array<const char*, 4> names,
                                           bool attributes) {
  std::array<double, 4> box{};
  for (std::size_t i = 0; i < box.size(); ++i) {
    const auto value = parseNumber<double>(attributes ? element.attribute(names[i]) : element.textOf(names[i]));
    if (!value) return std::nullopt;
    box[i] = *value;
  }
  if (box[0] > box[2] || box[1] > box[3]) return std::nullopt;
  return box;
}

constexpr std::array<const char*, 4> kCorners = {"minx", "miny", "maxx", "maxy"};
constexpr std::array<const char*, 4> kBounds = {"westBoundLongitude", "southBoundLatitude", "eastBoundLongitude",
                                                "northBoundLatitude"};

void readBoxes(const XmlElement& element, WmsLayer& layer) {
  if (const XmlElement* box = element.child("EX_GeographicBoundingBox")) {
    if (const auto values = boxOf(*box, kBounds, false)) layer.lonLatBox_degrees = values;
  } else if (const XmlElement* older = element.child("LatLonBoundingBox")) {
    if (const auto values = boxOf(*older, kCorners, true)) layer.lonLatBox_degrees = values;
  }
  for (const XmlElement* box : element.all("BoundingBox")) {
    const std::string_view crs = box->attribute("CRS").empty() ? box->attribute("SRS") : box->attribute("CRS");
    const auto values = boxOf(*box, kCorners, true);
    if (!values || crs.empty()) continue;
    layer.boxes.push_back({std::string(crs), *values});
  }
}

/// 1.3.0 has all in <Dimension>; before, <Dimension> declares units and <Extent> gives the values.
void readDimensions(const XmlElement& element, std::vector<WmsDimension>& dimensions) {
  const auto named = [&](std::string_view name) -> WmsDimension& {
    const std::string key = lowered(name);
    const auto found = std::ranges::find(dimensions, key, &WmsDimension::name);
    if (found != dimensions.end()) return *found;
    return dimensions.emplace_back(WmsDimension{key, {}, {}, {}, false, false});
  };
  for (const char* tag : {"Dimension", "Extent"}) {
    for (const XmlElement* part : element.all(tag)) {
      if (part->attribute("name").empty()) continue;
      WmsDimension& dimension = named(part->attribute("name"));
      if (!part->attribute("units").empty()) dimension.units = part->attribute("units");
      const bool hasValues = !part->text.empty() || !part->attribute("default").empty();
      if (!hasValues) continue;
      dimension.values = part->text;
      dimension.defaultValue = part->attribute("default");
      dimension.nearestValue = isTrue(part->attribute("nearestValue"));
      dimension.current = isTrue(part->attribute("current")) || dimension.defaultValue == "current";
    }
  }
}

void readScales(const XmlElement& element, WmsLayer& layer) {
  const auto positive = [](std::string_view text, double factor, std::optional<double>& scale) {
    if (text.empty()) return;
    const auto value = parseNumber<double>(text);
    scale = value && *value > 0.0 ? std::optional(*value * factor) : std::nullopt;
  };
  positive(element.textOf("MinScaleDenominator"), 1.0, layer.minScaleDenominator);
  positive(element.textOf("MaxScaleDenominator"), 1.0, layer.maxScaleDenominator);
  if (const XmlElement* hint = element.child("ScaleHint")) {  // metres along the diagonal of a pixel
    const double factor = 1.0 / (std::sqrt(2.0) * kStandardPixel_m);
    positive(hint->attribute("min"), factor, layer.minScaleDenominator);
    positive(hint->attribute("max"), factor, layer.maxScaleDenominator);
  }
}

/// Adds those of `outer` that `own` has not.
template <class T, class Key>
void addMissing(const std::vector<T>& outer, std::vector<T>& own, Key key) {
  if (outer.empty()) return;
  std::unordered_set<std::string> known;
  for (const T& one : own)
    known.insert(std::invoke(key, one));
  for (const T& one : outer)
    if (known.insert(std::invoke(key, one)).second) own.push_back(one);
}

void readLists(const XmlElement& element, WmsLayer& layer) {
  for (const XmlElement* style : element.all("Style"))
    if (const std::string_view name = style->textOf("Name"); !name.empty())
      layer.styles.push_back({std::string(name), std::string(style->textOf("Title"))});
  std::vector<std::string> references;
  for (const char* tag : {"CRS", "SRS"})
    for (const XmlElement* crs : element.all(tag))
      std::ranges::move(words(crs->text), std::back_inserter(references));
  addMissing(references, layer.crs, std::identity{});
  readBoxes(element, layer);
  readDimensions(element, layer.dimensions);
}

/// A dimension that a layer only declares has its values from around it.
void addDimensions(const std::vector<WmsDimension>& outer, std::vector<WmsDimension>& own) {
  for (WmsDimension& dimension : own) {
    const auto found = std::ranges::find(outer, dimension.name, &WmsDimension::name);
    if (found == outer.end()) continue;
    const std::string units = dimension.units.empty() ? found->units : dimension.units;
    if (dimension.values.empty()) dimension = *found;
    dimension.units = units;
  }
  addMissing(outer, own, &WmsDimension::name);
}

/// False: too many of something.
bool readLayer(const XmlElement& element, const WmsLayer& outer, int parent, std::vector<WmsLayer>& layers) {
  WmsLayer layer;
  layer.parent = parent;
  layer.depth = parent < 0 ? 0 : outer.depth + 1;
  layer.name = element.textOf("Name");
  layer.title = element.textOf("Title");
  layer.abstract = element.textOf("Abstract");
  layer.queryable = outer.queryable;
  layer.opaque = outer.opaque;
  layer.noSubsets = outer.noSubsets;
  layer.fixedWidth = outer.fixedWidth;
  layer.fixedHeight = outer.fixedHeight;
  layer.lonLatBox_degrees = outer.lonLatBox_degrees;
  layer.attribution = outer.attribution;
  layer.minScaleDenominator = outer.minScaleDenominator;
  layer.maxScaleDenominator = outer.maxScaleDenominator;
  replaceFlag(element, "queryable", layer.queryable);
  replaceFlag(element, "opaque", layer.opaque);
  replaceFlag(element, "noSubsets", layer.noSubsets);
  replaceCount(element.attribute("fixedWidth"), layer.fixedWidth);
  replaceCount(element.attribute("fixedHeight"), layer.fixedHeight);
  if (const std::string_view title = element.textOf("Attribution/Title"); !title.empty())
    layer.attribution = onOneLine(title);
  readScales(element, layer);
  // Counted before they are read: what looks through a list for each of its entries costs the square.
  const auto count = static_cast<std::size_t>(
      std::ranges::count_if(element.children, [](const XmlElement& part) { return part.name != "Layer"; }));
  if (count > kMostParts || layers.size() >= kMostLayers) return false;
  readLists(element, layer);
  if (layer.crs.size() > kMostParts) return false;
  layers.push_back(layer);
  const int place = static_cast<int>(layers.size()) - 1;
  return std::ranges::all_of(element.children, [&](const XmlElement& child) {
    return child.name != "Layer" || readLayer(child, layer, place, layers);
  });
}

std::vector<std::string> formatsOf(const XmlElement* operation) {
  std::vector<std::string> formats;
  if (operation == nullptr) return formats;
  for (const XmlElement* format : operation->all("Format")) {
    if (!format->text.empty()) formats.push_back(format->text);
    for (const XmlElement& older : format->children)  // 1.0.0: <Format><PNG/><JPEG/></Format>
      formats.push_back(older.name);
  }
  return formats;
}

std::string getUrlOf(const XmlElement& operation) {
  for (const XmlElement* type : operation.all("DCPType")) {
    const XmlElement* get = type->find("HTTP/Get");
    if (get == nullptr) continue;
    if (const XmlElement* online = get->child("OnlineResource")) return std::string(online->attribute("href"));
    return std::string(get->attribute("onlineResource"));
  }
  return {};
}

}  // namespace

const WmsDimension* WmsLayer::dimension(std::string_view dimensionName) const {
  const auto found = std::ranges::find(dimensions, dimensionName, &WmsDimension::name);
  return found == dimensions.end() ? nullptr : &*found;
}

const WmsLayer* WmsCapabilities::layer(std::string_view name) const {
  const auto found = std::ranges::find(layers, name, &WmsLayer::name);
  return found == layers.end() ? nullptr : &*found;
}

WmsLayer WmsCapabilities::withInherited(const WmsLayer& layer) const {
  WmsLayer whole = layer;
  for (int place = layer.parent; place >= 0; place = layers[static_cast<std::size_t>(place)].parent) {
    const WmsLayer& outer = layers[static_cast<std::size_t>(place)];
    addMissing(outer.styles, whole.styles, &WmsStyle::name);
    addMissing(outer.crs, whole.crs, std::identity{});
    addMissing(outer.boxes, whole.boxes, &WmsBox::crs);
    addDimensions(outer.dimensions, whole.dimensions);
  }
  return whole;
}

io::Result<WmsCapabilities> parseWmsCapabilities(const XmlElement& root, const std::string& where) {
  if (const auto exception = serviceExceptionText(root)) {
    return io::fail(io::Failure::Code::ioError, "the server says: " + *exception, where);
  }
  if (root.name != "WMS_Capabilities" && root.name != "WMT_MS_Capabilities") {
    return io::fail(io::Failure::Code::corrupt,
                    fmt::format("no capabilities of a WMS: the document is a <{}>", root.name.substr(0, 80)), where);
  }
  WmsCapabilities capabilities;
  capabilities.version = root.attribute("version");
  capabilities.title = root.textOf("Service/Title");
  capabilities.abstract = root.textOf("Service/Abstract");
  replaceCount(root.textOf("Service/MaxWidth"), capabilities.maxWidth);
  replaceCount(root.textOf("Service/MaxHeight"), capabilities.maxHeight);
  replaceCount(root.textOf("Service/LayerLimit"), capabilities.layerLimit);
  const XmlElement* getMap = root.find("Capability/Request/GetMap");
  if (getMap == nullptr) getMap = root.find("Capability/Request/Map");
  capabilities.formats = formatsOf(getMap);
  if (getMap != nullptr) capabilities.getMapUrl = getUrlOf(*getMap);
  capabilities.exceptionFormats = formatsOf(root.find("Capability/Exception"));
  if (const XmlElement* capability = root.child("Capability"))
    for (const XmlElement* layer : capability->all("Layer"))
      if (!readLayer(*layer, WmsLayer{}, -1, capabilities.layers)) {
        return io::fail(io::Failure::Code::unsupported,
                        fmt::format("the capabilities have more than {} layers, or a layer of more than {} parts",
                                    kMostLayers, kMostParts),
                        where);
      }
  if (capabilities.layers.empty())
    return io::fail(io::Failure::Code::corrupt, "the capabilities of this WMS name no layer", where);
  return capabilities;
}

}  // namespace tellurion::raster
