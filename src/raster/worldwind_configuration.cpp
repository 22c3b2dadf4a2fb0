#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "raster/parse_number.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"
#include "raster/worldwind_service.h"

namespace tellurion::raster {
namespace {

constexpr std::array<const char*, 4> kSides = {"West", "South", "East", "North"};

std::string formatOfExtension(std::string_view extension, Kind kind) {
  const std::string name = lowered(extension.starts_with('.') ? extension.substr(1) : extension);
  if (name.empty()) return {};
  if (name == "bil") return "application/bil16";
  if (kind == Kind::elevation && name.starts_with("tif")) return "image/tiff";
  return name == "jpg" ? "image/jpeg" : "image/" + name;
}

std::optional<int> finestOf(std::string_view count) {
  const auto levels = parseNumber<int>(count);
  return levels && *levels > 0 ? std::optional(*levels - 1) : std::nullopt;
}

/// <North><Value>90</Value></North>...
std::optional<std::array<double, 4>> dotNetBox(const XmlElement* box) {
  if (box == nullptr) return std::nullopt;
  std::array<double, 4> sides{};
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const auto value = parseNumber<double>(box->textOf(std::string(kSides[i]) + "/Value"));
    if (!value) return std::nullopt;
    sides[i] = *value;
  }
  return sides;
}

/// "name&TRANSPARENT=TRUE": only the name is one.
std::string nameOnly(std::string_view name) {
  return std::string(name.substr(0, name.find('&')));
}

void addQuadTileSet(const XmlElement& set, std::vector<WorldWindLayer>& layers) {
  for (const XmlElement* accessor : set.all("ImageAccessor")) {
    WorldWindLayer layer;
    layer.title = onOneLine(set.textOf("Name"));
    ServiceLayer& entry = layer.entry;
    entry.bounds_degrees = dotNetBox(set.child("BoundingBox"));
    if (const XmlElement* service = accessor->child("ImageTileService")) {
      entry.type = "worldwind";
      entry.source = service->textOf("ServerUrl");
      entry.layer = service->textOf("DataSetName");
      entry.levelZero_degrees = parseNumber<double>(accessor->textOf("LevelZeroTileSizeDegrees"));
      entry.tilePixels = parseNumber<int>(accessor->textOf("TextureSizePixels"));
      entry.maxLevel = finestOf(accessor->textOf("NumberLevels"));
      entry.format = formatOfExtension(accessor->textOf("ImageFileExtension"), Kind::imagery);
    } else if (const XmlElement* wms = accessor->child("WMSAccessor")) {
      entry.type = "wms";
      entry.source = wms->textOf("ServerGetMapUrl");
      entry.layer = nameOnly(wms->textOf("WMSLayerName"));
      entry.style = wms->textOf("WMSLayerStyle");
      entry.version = wms->textOf("Version");
      entry.format = wms->textOf("ImageFormat");
    }
    if (!entry.source.empty() && !entry.layer.empty()) layers.push_back(std::move(layer));
  }
}

void addTerrain(const XmlElement& accessor, std::vector<WorldWindLayer>& layers) {
  const XmlElement* service = accessor.child("TerrainTileService");
  if (service == nullptr) return;
  WorldWindLayer layer;
  layer.title = onOneLine(accessor.attribute("Name"));
  layer.kind = Kind::elevation;
  ServiceLayer& entry = layer.entry;
  entry.type = "worldwind";
  entry.source = service->textOf("ServerUrl");
  entry.layer = service->textOf("DataSetName");
  entry.levelZero_degrees = parseNumber<double>(service->textOf("LevelZeroTileSizeDegrees"));
  entry.tilePixels = parseNumber<int>(service->textOf("SamplesPerTile"));
  entry.maxLevel = finestOf(service->textOf("NumberLevels"));
  const bool wide = lowered(service->textOf("DataFormat")) == "float32";
  const std::string format = formatOfExtension(service->textOf("FileExtension"), Kind::elevation);
  entry.format = wide && format == "application/bil16" ? "application/bil32" : format;
  entry.bounds_degrees = dotNetBox(accessor.child("LatLonBoundingBox"));
  if (!entry.source.empty() && !entry.layer.empty()) layers.push_back(std::move(layer));
}

std::optional<std::array<double, 4>> javaBox(const XmlElement& layer) {
  const XmlElement* southWest = layer.find("Sector/SouthWest/LatLon");
  const XmlElement* northEast = layer.find("Sector/NorthEast/LatLon");
  if (southWest == nullptr || northEast == nullptr) return std::nullopt;
  std::array<double, 4> box{};
  const std::array<std::string_view, 4> texts = {southWest->attribute("longitude"), southWest->attribute("latitude"),
                                                 northEast->attribute("longitude"), northEast->attribute("latitude")};
  for (std::size_t i = 0; i < box.size(); ++i) {
    const auto value = parseNumber<double>(texts[i]);
    if (!value) return std::nullopt;
    box[i] = *value;
  }
  return box;
}

/// World Wind Java asks a WMS for its tiles; which, is the WMS protocol's business here.
void addJavaLayer(const XmlElement& element, std::vector<WorldWindLayer>& layers) {
  const XmlElement* service = element.child("Service");
  if (service == nullptr || service->attribute("serviceName") != "OGC:WMS") return;
  WorldWindLayer layer;
  layer.title = onOneLine(element.textOf("DisplayName"));
  layer.kind = element.name == "ElevationModel" ? Kind::elevation : Kind::imagery;
  ServiceLayer& entry = layer.entry;
  entry.type = "wms";
  const std::string_view capabilities = service->textOf("GetCapabilitiesURL");
  entry.source = capabilities.empty() ? service->textOf("GetMapURL") : capabilities;
  entry.layer = service->textOf("LayerNames");
  entry.style = service->textOf("StyleNames");
  const std::string_view version = service->attribute("version");
  entry.version = version == "1.3" ? "1.3.0" : version;
  entry.format = element.textOf("ImageFormat");
  entry.bounds_degrees = javaBox(element);
  if (layer.kind == Kind::elevation) {
    if (const XmlElement* missing = element.child("MissingData"))
      entry.nodata = parseNumber<double>(missing->attribute("signal"));
  }
  if (!entry.source.empty() && !entry.layer.empty()) layers.push_back(std::move(layer));
}

void addLayers(const XmlElement& element, std::vector<WorldWindLayer>& layers) {
  if (element.name == "QuadTileSet") addQuadTileSet(element, layers);
  if (element.name == "TerrainAccessor") addTerrain(element, layers);
  if (element.name == "Layer" || element.name == "ElevationModel") addJavaLayer(element, layers);
  for (const XmlElement& child : element.children)
    addLayers(child, layers);
}

}  // namespace

bool isWorldWindConfiguration(const XmlElement& root) {
  constexpr std::array kRoots = {"LayerSet", "World", "Layer", "ElevationModel", "LayerList"};
  return std::ranges::find(kRoots, root.name) != kRoots.end();
}

io::Result<std::vector<WorldWindLayer>> parseWorldWindConfiguration(const XmlElement& root, const std::string& where) {
  std::vector<WorldWindLayer> layers;
  if (isWorldWindConfiguration(root)) addLayers(root, layers);
  if (layers.empty()) {
    return io::fail(io::Failure::Code::unsupported, "this World Wind configuration names no tiles of a server", where);
  }
  return layers;
}

}  // namespace tellurion::raster
