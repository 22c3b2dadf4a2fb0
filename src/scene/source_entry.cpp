#include "scene/source_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>

#include "pyramid/remote_database.h"
#include "raster/service_url.h"
#include "scene/layer_entry.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 18> kServiceKeys{"layer",
                                                        "style",
                                                        "format",
                                                        "crs",
                                                        "version",
                                                        "time",
                                                        "matrix_set",
                                                        "encoding",
                                                        "byte_order",
                                                        "scale",
                                                        "offset",
                                                        "nodata",
                                                        "level_zero_degrees",
                                                        "tile_pixels",
                                                        "min_level",
                                                        "max_level",
                                                        "bounds",
                                                        "attribution"};
constexpr int kDeepestServiceLevel = 30;

std::string absence(const fs::path& path, std::string_view kind, const fs::path& folder) {
  std::string text = fmt::format("there is no file {}", path.string());
  if (path.extension() != ".tdb") return text;
  text += fmt::format("; build it: tellurion build {} INPUT... --kind {}", path.string(), kind);
  std::error_code error;
  if (fs::exists(folder / "demo.sh", error)) text += "; or './bootstrap demo' makes all that the demo's scenes need";
  return text;
}

std::array<double, 4> bounds(const Entry& entry) {
  if (entry.shape != Entry::Shape::list || entry.parts.size() != 4)
    complain(entry.where, "'bounds' must be [west, south, east, north] in degrees");
  std::array<double, 4> out{};
  for (std::size_t i = 0; i < 4; ++i)
    out[i] = asNumber(entry.parts[i], i % 2 == 0 ? -540.0 : -90.0, i % 2 == 0 ? 540.0 : 90.0);
  if (out[1] >= out[3]) complain(entry.where, "'bounds' must have the south below the north");
  return out;
}

raster::ServiceLayer service(const Entry& layer, const std::string& source, const std::string& type) {
  const auto text = [&](std::string_view key) { return textAt(layer, key).value_or(""); };
  const auto real = [&](std::string_view key, double low, double high) {
    const Entry* entry = find(layer, key);
    return entry != nullptr ? std::optional(asNumber(*entry, low, high)) : std::nullopt;
  };
  const auto whole = [&](std::string_view key, int low, int high) {
    const Entry* entry = find(layer, key);
    return entry != nullptr ? std::optional(asWhole(*entry, low, high)) : std::nullopt;
  };
  raster::ServiceLayer out{.source = source, .type = type};
  out.layer = text("layer");
  out.style = text("style");
  out.format = text("format");
  out.crs = text("crs");
  out.version = text("version");
  out.time = text("time");
  out.matrixSet = text("matrix_set");
  out.encoding = text("encoding");
  out.byteOrder = text("byte_order");
  out.attribution = text("attribution");
  out.scale = real("scale", -1e9, 1e9);
  out.offset_m = real("offset", -1e9, 1e9);
  out.nodata = real("nodata", -1e300, 1e300);
  out.levelZero_degrees = real("level_zero_degrees", 1e-6, 360.0);
  out.tilePixels = whole("tile_pixels", 16, 4096);
  out.minLevel = whole("min_level", 0, kDeepestServiceLevel);
  out.maxLevel = whole("max_level", 0, kDeepestServiceLevel);
  if (const Entry* entry = find(layer, "bounds")) out.bounds_degrees = bounds(*entry);
  return out;
}

/// All but the first of a list of sources.
void readFurther(const std::vector<Entry>& several, std::string_view kind, const std::string& type,
                 const fs::path& folder, LayerSourceEntry& out) {
  for (std::size_t i = 0; i < several.size(); ++i) {
    const std::string source = sourceAt(several[i], folder);
    if (out.from == SourceKind::service || (type.empty() && sourceKindOf(source) == SourceKind::service))
      complain(several[i].where, "a list of sources is of files; make the layer of a server one of its own");
    expectFile(several[i], source, kind, folder);
    if (i > 0) out.alsoFrom.push_back(source);
  }
}

}  // namespace

Keys withServiceKeys(Keys keys) {
  keys.insert(keys.end(), kServiceKeys.begin(), kServiceKeys.end());
  return keys;
}

std::string sourceAt(const Entry& entry, const fs::path& folder) {
  std::string text = asText(entry);
  if (isServiceUrl(text)) return text;
  const fs::path path(text);
  return (path.is_absolute() ? path : folder / path).string();
}

SourceKind kindOfSource(const Entry& layer, const std::string& type, const std::string& source) {
  if (type.empty()) return sourceKindOf(source);
  if (type == "live") return SourceKind::live;
  if (type == "catalogue") return SourceKind::catalogue;
  const Keys services{"wms", "wmts", "tms", "xyz", "worldwind"};
  if (std::ranges::find(services, type) == services.end()) {
    complain(find(layer, "type")->where,
             fmt::format("no type '{}'; allowed: {}, live, catalogue; of imagery also hillshade, slope, palette", type,
                         fmt::join(services, ", ")));
  }
  return SourceKind::service;
}

void expectFile(const Entry& entry, const std::string& source, std::string_view kind, const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(source, error)) complain(entry.where, absence(source, kind, folder), io::Failure::Code::notFound);
}

LayerSourceEntry readSource(const Entry& layer, std::string_view kind, bool mayBeSeveral, const fs::path& folder) {
  const Entry* entry = find(layer, "source");
  if (entry == nullptr) complain(layer.where, "the layer has no source");
  const bool isList = mayBeSeveral && entry->shape == Entry::Shape::list;
  if (isList && entry->parts.empty()) complain(entry->where, "the layer's list of sources is empty");
  LayerSourceEntry out;
  out.source = sourceAt(isList ? entry->parts.front() : *entry, folder);
  const std::string type = textAt(layer, "type").value_or("");
  out.from = kindOfSource(layer, type, out.source);
  if (isList && entry->parts.size() > 1) readFurther(entry->parts, kind, type, folder, out);
  const bool isDatabase = type.empty() && pyramid::isRemoteDatabase(out.source);
  if (out.from == SourceKind::service && !isDatabase) {
    out.service = service(layer, out.source, type);
    return out;
  }
  for (const Entry& field : layer.parts) {
    if (std::ranges::find(kServiceKeys, field.key) != kServiceKeys.end())
      complain(field.keyWhere, fmt::format("'{}' is for layers of services; say which with type", field.key));
  }
  if (isDatabase) {
    out.service.source = out.source;
    return out;
  }
  if (isServiceUrl(out.source))
    complain(entry->where,
             fmt::format("{}: type = \"{}\" is for files of this machine", raster::withoutSecrets(out.source), type));
  expectFile(*entry, out.source, kind, folder);
  return out;
}

}  // namespace tellurion::scene
