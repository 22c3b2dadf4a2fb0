#include "raster/wmts_capabilities.h"

#include <fmt/format.h>

#include <algorithm>

#include "raster/grid_geometry.h"
#include "raster/parse_number.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"

namespace tellurion::raster {
namespace {

constexpr std::size_t kMostLayers = 20'000;
/// Tile matrix sets; matrices of a set, links and styles of a layer, limits of a link: some are looked for among
/// others.
constexpr std::size_t kMostParts = 4'096;

template <class T>
const T* byName(const std::vector<T>& all, std::string_view name) {
  const auto found = std::ranges::find(all, name, &T::name);
  return found == all.end() ? nullptr : &*found;
}

std::optional<std::array<double, 4>> boxOf(const XmlElement& layer) {
  const XmlElement* box = layer.child("WGS84BoundingBox");
  if (box == nullptr) return std::nullopt;
  const std::vector<double> lower = parseNumbers(box->textOf("LowerCorner"));
  const std::vector<double> upper = parseNumbers(box->textOf("UpperCorner"));
  if (lower.size() != 2 || upper.size() != 2 || lower[1] > upper[1]) return std::nullopt;
  return std::array{lower[0], lower[1], upper[0], upper[1]};
}

bool readMatrix(const XmlElement& element, WmtsMatrix& matrix) {
  constexpr std::int64_t kMostTiles = std::int64_t{1} << 40;
  const auto scale = parseNumber<double>(element.textOf("ScaleDenominator"));
  const std::vector<double> corner = parseNumbers(element.textOf("TopLeftCorner"));
  const auto tileWidth = parseNumber<int>(element.textOf("TileWidth"));
  const auto tileHeight = parseNumber<int>(element.textOf("TileHeight"));
  const auto width = parseNumber<std::int64_t>(element.textOf("MatrixWidth"));
  const auto height = parseNumber<std::int64_t>(element.textOf("MatrixHeight"));
  if (!scale || *scale <= 0.0 || corner.size() != 2 || !tileWidth || !tileHeight || !width || !height) return false;
  const auto inside = [](auto value, auto most) { return value >= 1 && value <= most; };
  if (!inside(*tileWidth, kMaxImageSide) || !inside(*tileHeight, kMaxImageSide)) return false;
  if (!inside(*width, kMostTiles) || !inside(*height, kMostTiles)) return false;
  matrix = {std::string(element.textOf("Identifier")),
            *scale,
            {corner[0], corner[1]},
            *tileWidth,
            *tileHeight,
            *width,
            *height};
  return true;
}

/// Times are many, and only gone through once.
bool hasTooMuch(const XmlElement& element) {
  if (element.children.size() > kMostParts) return true;
  std::size_t linked = 0;
  for (const XmlElement* link : element.all("TileMatrixSetLink"))
    linked += link->children.size();
  if (linked > 2 * kMostParts) return true;
  return std::ranges::any_of(element.children, [](const XmlElement& child) {
    const XmlElement* limits = child.child("TileMatrixSetLimits");
    return limits != nullptr && limits->children.size() > kMostParts;
  });
}

WmtsMatrixSet matrixSetOf(const XmlElement& element) {
  WmtsMatrixSet set;
  set.name = element.textOf("Identifier");
  set.crs = element.textOf("SupportedCRS");
  for (const XmlElement* child : element.all("TileMatrix"))
    if (WmtsMatrix matrix; readMatrix(*child, matrix)) set.matrices.push_back(std::move(matrix));
  return set;
}

/// The standard has one set in a link; some servers name several. Limits are of matrices by name, so of one set only.
void addLinks(const XmlElement& element, std::vector<WmtsLink>& links) {
  const auto sets = element.all("TileMatrixSet");
  for (const XmlElement* set : sets)
    links.push_back({.matrixSet = set->text, .limits = {}});
  const XmlElement* limits = element.child("TileMatrixSetLimits");
  if (sets.size() != 1 || limits == nullptr) return;
  for (const XmlElement* one : limits->all("TileMatrixLimits")) {
    const auto minRow = parseNumber<std::int64_t>(one->textOf("MinTileRow"));
    const auto maxRow = parseNumber<std::int64_t>(one->textOf("MaxTileRow"));
    const auto minColumn = parseNumber<std::int64_t>(one->textOf("MinTileCol"));
    const auto maxColumn = parseNumber<std::int64_t>(one->textOf("MaxTileCol"));
    if (minRow && maxRow && minColumn && maxColumn)
      links.back().limits.push_back({std::string(one->textOf("TileMatrix")), *minRow, *maxRow, *minColumn, *maxColumn});
  }
}

WmtsLayer layerOf(const XmlElement& element) {
  WmtsLayer layer;
  layer.name = element.textOf("Identifier");
  layer.title = element.textOf("Title");
  layer.abstract = element.textOf("Abstract");
  layer.lonLatBox_degrees = boxOf(element);
  for (const XmlElement* style : element.all("Style")) {
    layer.styles.push_back({std::string(style->textOf("Identifier")), std::string(style->textOf("Title")),
                            lowered(style->attribute("isDefault")) == "true"});
  }
  for (const XmlElement* format : element.all("Format"))
    layer.formats.push_back(format->text);
  for (const XmlElement* dimension : element.all("Dimension")) {
    WmtsDimension& made = layer.dimensions.emplace_back();
    made.name = dimension->textOf("Identifier");
    made.defaultValue = dimension->textOf("Default");
    for (const XmlElement* value : dimension->all("Value"))
      made.values.push_back(value->text);
  }
  for (const XmlElement* link : element.all("TileMatrixSetLink"))
    addLinks(*link, layer.links);
  for (const XmlElement* resource : element.all("ResourceURL"))
    if (resource->attribute("resourceType") == "tile")
      layer.templates.push_back(
          {std::string(resource->attribute("format")), std::string(resource->attribute("template"))});
  return layer;
}

bool takesKeyValues(const XmlElement& get) {
  const XmlElement* allowed = get.find("Constraint/AllowedValues");
  if (allowed == nullptr) return true;
  return std::ranges::any_of(allowed->all("Value"), [](const XmlElement* value) { return value->text == "KVP"; });
}

std::string getTileUrlOf(const XmlElement& root) {
  const XmlElement* operations = root.child("OperationsMetadata");
  if (operations == nullptr) return {};
  for (const XmlElement* operation : operations->all("Operation")) {
    const XmlElement* http = operation->find("DCP/HTTP");
    if (operation->attribute("name") != "GetTile" || http == nullptr) continue;
    for (const XmlElement* get : http->all("Get"))
      if (takesKeyValues(*get)) return std::string(get->attribute("href"));
  }
  return {};
}

}  // namespace

const WmtsDimension* WmtsLayer::dimension(std::string_view dimensionName) const {
  const auto found = std::ranges::find_if(
      dimensions, [&](const WmtsDimension& one) { return lowered(one.name) == lowered(dimensionName); });
  return found == dimensions.end() ? nullptr : &*found;
}

const WmtsLayer* WmtsCapabilities::layer(std::string_view name) const {
  return byName(layers, name);
}
const WmtsMatrixSet* WmtsCapabilities::matrixSet(std::string_view name) const {
  return byName(matrixSets, name);
}

io::Result<WmtsCapabilities> parseWmtsCapabilities(const XmlElement& root, const std::string& where) {
  if (const auto exception = serviceExceptionText(root))
    return io::fail(io::Failure::Code::ioError, "the server says: " + *exception, where);
  const XmlElement* contents = root.child("Contents");
  if (root.name != "Capabilities" || contents == nullptr) {
    return io::fail(io::Failure::Code::corrupt,
                    fmt::format("no capabilities of a WMTS: the document is a <{}>", root.name.substr(0, 80)), where);
  }
  WmtsCapabilities capabilities;
  capabilities.version = root.attribute("version");
  capabilities.title = onOneLine(root.textOf("ServiceIdentification/Title"));
  capabilities.abstract = root.textOf("ServiceIdentification/Abstract");
  capabilities.attribution = onOneLine(root.textOf("ServiceProvider/ProviderName"));
  capabilities.getTileUrl = getTileUrlOf(root);
  const auto layers = contents->all("Layer");
  const auto sets = contents->all("TileMatrixSet");
  const bool isTooMuch = layers.size() > kMostLayers || sets.size() > kMostParts ||
                         std::ranges::any_of(layers, [](const XmlElement* layer) { return hasTooMuch(*layer); }) ||
                         std::ranges::any_of(sets, [](const XmlElement* set) { return hasTooMuch(*set); });
  if (isTooMuch) {
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("the capabilities have more than {} layers, or more than {} tile matrix sets, or a "
                                "layer or set of more than {} parts",
                                kMostLayers, kMostParts, kMostParts),
                    where);
  }
  for (const XmlElement* layer : layers)
    capabilities.layers.push_back(layerOf(*layer));
  for (const XmlElement* set : sets)
    capabilities.matrixSets.push_back(matrixSetOf(*set));
  if (capabilities.layers.empty())
    return io::fail(io::Failure::Code::corrupt, "the capabilities of this WMTS name no layer", where);
  return capabilities;
}

}  // namespace tellurion::raster
