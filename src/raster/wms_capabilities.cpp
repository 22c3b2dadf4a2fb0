#include "raster/wms_capabilities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "raster/map_reference.h"
#include "raster/parse_number.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

constexpr std::size_t kMostLayers = 20'000;
constexpr std::size_t kMostParts = 8'192;    // of one layer
constexpr std::size_t kMostDimensions = 64;  // of one layer; each is looked for among all
constexpr std::size_t kMostInAll = 250'000;  // styles, references, boxes and dimensions of all layers

/// The first `most` words.
std::vector<std::string_view> words(std::string_view text, std::size_t most) {
  constexpr const char* kSpace = " \t\r\n";
  std::vector<std::string_view> found;
  for (std::size_t at = text.find_first_not_of(kSpace); at != text.npos && found.size() < most;
       at = text.find_first_not_of(kSpace, at)) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    found.push_back(text.substr(at, end - at));
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
    return dimensions.emplace_back(WmsDimension{key, {}, {}, {}, false});
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

void readLists(const XmlElement& element, WmsLayer& layer) {
  for (const XmlElement* style : element.all("Style"))
    if (const std::string_view name = style->textOf("Name"); !name.empty())
      layer.styles.push_back({std::string(name), std::string(style->textOf("Title"))});
  std::unordered_set<std::string_view> known;
  for (const char* tag : {"CRS", "SRS"}) {
    for (const XmlElement* crs : element.all(tag)) {
      for (const std::string_view name : words(crs->text, kMostParts + 1 - std::min(layer.crs.size(), kMostParts)))
        if (known.insert(name).second) layer.crs.emplace_back(name);
    }
  }
  readBoxes(element, layer);
  readDimensions(element, layer.dimensions);
}

/// A layer's lists, then those around it, from within outwards.
using Path = std::vector<const WmsLayer*>;

/// The layer's own of a list, and those of the layers around it whose key is new. One set for the whole path: it may
/// be long, and so may each list.
template <class T, class Key>
std::vector<T> inherited(const Path& path, std::vector<T> WmsLayer::*list, Key key) {
  std::vector<T> all = path.front()->*list;
  std::unordered_set<std::string_view> known;
  for (const T& own : path.front()->*list)
    known.insert(std::invoke(key, own));
  for (const WmsLayer* outer : std::span(path).subspan(1))
    for (const T& one : outer->*list)
      if (known.insert(std::invoke(key, one)).second) all.push_back(one);
  return all;
}

/// A dimension that a layer only declares has its values from around it.
std::vector<WmsDimension> inheritedDimensions(const Path& path) {
  std::vector<WmsDimension> all = inherited(path, &WmsLayer::dimensions, &WmsDimension::name);
  std::unordered_map<std::string_view, WmsDimension*> open;
  for (WmsDimension& dimension : all)
    if (dimension.values.empty() || dimension.units.empty()) open.emplace(dimension.name, &dimension);
  for (const WmsLayer* layer : path) {
    for (const WmsDimension& outer : layer->dimensions) {
      const auto found = open.find(outer.name);
      if (found == open.end()) continue;
      WmsDimension& dimension = *found->second;
      if (dimension.units.empty()) dimension.units = outer.units;
      if (!dimension.values.empty() || outer.values.empty()) continue;
      dimension.values = outer.values;
      dimension.defaultValue = outer.defaultValue;
      dimension.nearestValue = outer.nearestValue;
    }
  }
  return all;
}

/// What there is too much of; empty: nothing.
std::string readLayer(const XmlElement& element, int parent, WmsCapabilities& capabilities, std::size_t& parts) {
  std::vector<WmsLayer>& layers = capabilities.layers;
  if (layers.size() >= kMostLayers) return fmt::format("more than {} layers", kMostLayers);
  WmsLayer layer;
  layer.parent = parent;
  if (parent >= 0) {
    const WmsLayer& outer = layers[static_cast<std::size_t>(parent)];
    layer.depth = outer.depth + 1;
    layer.noSubsets = outer.noSubsets;
    layer.fixedWidth = outer.fixedWidth;
    layer.fixedHeight = outer.fixedHeight;
    layer.lonLatBox_degrees = outer.lonLatBox_degrees;
    layer.attribution = outer.attribution;
    layer.minScaleDenominator = outer.minScaleDenominator;
    layer.maxScaleDenominator = outer.maxScaleDenominator;
  }
  layer.name = element.textOf("Name");
  layer.title = element.textOf("Title");
  layer.abstract = element.textOf("Abstract");
  replaceFlag(element, "noSubsets", layer.noSubsets);
  replaceCount(element.attribute("fixedWidth"), layer.fixedWidth);
  replaceCount(element.attribute("fixedHeight"), layer.fixedHeight);
  if (const std::string_view title = element.textOf("Attribution/Title"); !title.empty())
    layer.attribution = onOneLine(title);
  readScales(element, layer);
  // Counted before they are read: what looks through a list for each of its entries costs the square.
  std::size_t children = 0;
  std::size_t dimensions = 0;
  for (const XmlElement& part : element.children) {
    if (part.name != "Layer") ++children;
    if (part.name == "Dimension" || part.name == "Extent") ++dimensions;
  }
  const auto tooManyParts = [] {
    return fmt::format("a layer of more than {} parts or {} dimensions", kMostParts, kMostDimensions);
  };
  if (children > kMostParts || dimensions > 2 * kMostDimensions) return tooManyParts();
  readLists(element, layer);
  if (layer.crs.size() > kMostParts || layer.dimensions.size() > kMostDimensions) return tooManyParts();
  parts += layer.styles.size() + layer.crs.size() + layer.boxes.size() + layer.dimensions.size();
  if (parts > kMostInAll) return fmt::format("more than {} styles, references, boxes and dimensions", kMostInAll);
  const int place = static_cast<int>(layers.size());
  layers.push_back(std::move(layer));
  for (const XmlElement& child : element.children) {
    if (child.name != "Layer") continue;
    if (std::string tooMuch = readLayer(child, place, capabilities, parts); !tooMuch.empty()) return tooMuch;
  }
  return {};
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
  Path path = {&layer};
  for (int place = layer.parent; place >= 0; place = path.back()->parent)
    path.push_back(&layers[static_cast<std::size_t>(place)]);
  WmsLayer whole = layer;
  whole.styles = inherited(path, &WmsLayer::styles, &WmsStyle::name);
  whole.crs = inherited(path, &WmsLayer::crs, std::identity{});
  whole.boxes = inherited(path, &WmsLayer::boxes, &WmsBox::crs);
  whole.dimensions = inheritedDimensions(path);
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
  std::size_t parts = 0;
  if (const XmlElement* capability = root.child("Capability")) {
    for (const XmlElement* layer : capability->all("Layer")) {
      if (const std::string tooMuch = readLayer(*layer, -1, capabilities, parts); !tooMuch.empty())
        return io::fail(io::Failure::Code::unsupported, fmt::format("the capabilities have {}", tooMuch), where);
    }
  }
  if (capabilities.layers.empty())
    return io::fail(io::Failure::Code::corrupt, "the capabilities of this WMS name no layer", where);
  return capabilities;
}

}  // namespace tellurion::raster
