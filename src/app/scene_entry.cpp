#include "app/scene_entry.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace tellurion::app {
namespace {

constexpr auto kReplaceWrongUtf8 = nlohmann::json::error_handler_t::replace;

}  // namespace

nlohmann::ordered_json entryJson(const raster::ServiceLayer& entry) {
  nlohmann::ordered_json json;
  const auto text = [&](const char* key, const std::string& value) {
    if (!value.empty()) json[key] = value;
  };
  const auto number = [&](const char* key, const auto& value) {
    if (value) json[key] = *value;
  };
  text("source", entry.source);
  text("type", entry.type);
  text("layer", entry.layer);
  text("style", entry.style);
  text("format", entry.format);
  text("crs", entry.crs);
  text("version", entry.version);
  text("time", entry.time);
  text("matrix_set", entry.matrixSet);
  text("encoding", entry.encoding);
  text("byte_order", entry.byteOrder);
  number("scale", entry.scale);
  number("offset", entry.offset_m);
  number("nodata", entry.nodata);
  number("level_zero_degrees", entry.levelZero_degrees);
  number("tile_pixels", entry.tilePixels);
  number("min_level", entry.minLevel);
  number("max_level", entry.maxLevel);
  number("bounds", entry.bounds_degrees);
  text("attribution", entry.attribution);
  return json;
}

std::string tomlOf(const raster::ServiceLayer& entry, raster::Kind kind) {
  std::string toml = fmt::format("[[{}]]\n", raster::nameOf(kind));
  // Texts, numbers and arrays of numbers are written alike in JSON and TOML.
  const nlohmann::ordered_json json = entryJson(entry);
  for (const auto& [key, value] : json.items())
    toml += fmt::format("{} = {}\n", key, value.dump(-1, ' ', false, kReplaceWrongUtf8));
  return toml;
}

}  // namespace tellurion::app
