#include "scene/layer_tables.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/layer_entry.h"
#include "scene/source_entry.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostTimes = 10000;  ///< of a layer
constexpr std::size_t kMostStops = 1000;   ///< of a ramp of colours

LayerLook look(const Entry& layer) {
  LayerLook out;
  const auto adjustment = [&](std::string_view key, double least) {
    return numberAt(layer, key, least, kMostAdjustment, 1.0);
  };
  out.visible = booleanAt(layer, "visible", true);
  out.opacity = numberAt(layer, "opacity", 0.0, 1.0, 1.0);
  out.brightness = adjustment("brightness", 0.0);
  out.contrast = adjustment("contrast", 0.0);
  out.saturation = adjustment("saturation", 0.0);
  out.gamma = adjustment("gamma", kLeastGamma);
  if (const Entry* entry = find(layer, "blend")) {
    const std::string name = asText(*entry);
    const auto mode = blendModeByName(name);
    if (!mode)
      complain(entry->where, fmt::format("no blend mode '{}'; allowed: normal, multiply, screen, add, overlay", name));
    out.blend = *mode;
  }
  return out;
}

std::vector<raster::ColourStop> stopsIn(const Entry& list, double largest) {
  if (list.shape != Entry::Shape::list || list.parts.empty() || list.parts.size() > kMostStops)
    complain(list.where, fmt::format("'stops' must be a list of 1 to {} of [number, \"RRGGBB\"]", kMostStops));
  std::vector<raster::ColourStop> out;
  for (const Entry& stop : list.parts) {
    if (stop.shape != Entry::Shape::list || stop.parts.size() != 2)
      complain(stop.where, "each of 'stops' must be [number, \"RRGGBB\"]");
    const double value = asNumber(stop.parts[0], -largest, largest);
    if (!out.empty() && value < out.back().value) complain(stop.where, "'stops' must ascend");
    const auto rgb = asColour(stop.parts[1]);
    out.push_back({.value = value, .colour = {rgb[0], rgb[1], rgb[2], 255}});
  }
  return out;
}

/// Of slopes (no body), or of the heights of a body.
std::vector<raster::ColourStop> stops(const Entry& layer, std::string_view body) {
  const Entry* entry = find(layer, "stops");
  const bool isOfHeights = !body.empty();
  const bool isNamed = isOfHeights && (entry == nullptr || entry->isText());
  if (!isNamed && entry != nullptr) return stopsIn(*entry, isOfHeights ? 1e7 : 90.0);
  const std::string name = entry != nullptr ? asText(*entry) : std::string(body);
  const auto ramp = isOfHeights ? raster::heightRamp(name) : raster::slopeRamp();
  if (ramp.empty()) {
    complain(entry != nullptr ? entry->where : layer.where,
             fmt::format("no palette '{}'; 'stops' may be \"earth\", \"mars\", \"moon\" or "
                         "[[height_m, \"RRGGBB\"], ...]",
                         name));
  }
  return {ramp.begin(), ramp.end()};
}

/// A path or URL, or a table like one of [[elevation]].
ElevationLayer heightsOf(const Entry& entry, const fs::path& folder) {
  if (entry.shape == Entry::Shape::table) return readElevation(entry, folder);
  ElevationLayer out;
  out.source = sourceAt(entry, folder);
  out.from = sourceKindOf(out.source);
  if (out.from == SourceKind::service) {
    out.service.source = out.source;
  } else {
    expectFile(entry, out.source, "elevation", folder);
  }
  return out;
}

raster::HeightColours heightColours(const Entry& layer, const std::string& type, const std::string& body) {
  const double exaggeration = numberAt(layer, "exaggeration", 0.0, 100.0, 1.0);
  if (type == "slope") return raster::SlopeColours{.stops = stops(layer, {}), .exaggeration = exaggeration};
  if (type == "palette") return raster::Palette{stops(layer, body)};
  const auto angle = [&](std::string_view key, double low, double high, geo::Angle otherwise) {
    return geo::Angle::degrees(numberAt(layer, key, low, high, otherwise.degrees()));
  };
  const raster::Hillshade usual;
  return raster::Hillshade{.sunAzimuth = angle("sun_azimuth", -360.0, 360.0, usual.sunAzimuth),
                           .sunAltitude = angle("sun_altitude", 0.0, 90.0, usual.sunAltitude),
                           .exaggeration = exaggeration};
}

/// A picture of the heights that are known so far.
ImageryLayer derivedImagery(const Entry& layer, const std::string& type, const Scene& scene, const fs::path& folder) {
  Keys keys{"type",
            "of",
            "name",
            "visible",
            "opacity",
            "blend",
            "brightness",
            "gamma",
            "saturation",
            "contrast",
            type == "hillshade" ? "sun_azimuth" : "stops"};
  if (type == "hillshade") keys.emplace_back("sun_altitude");
  if (type != "palette") keys.emplace_back("exaggeration");
  allow(layer, keys);
  ImageryLayer out;
  out.name = textAt(layer, "name").value_or(type);
  out.look = look(layer);
  out.derived.emplace().colours = heightColours(layer, type, scene.body.name);
  if (const Entry* entry = find(layer, "of")) {
    out.derived->of = heightsOf(*entry, folder);
  } else if (scene.elevation.empty()) {
    complain(layer.where, fmt::format("a {} is made of heights; give the scene an [[elevation]] layer, or the "
                                      "layer a source of them with of = \"FILE\"",
                                      type));
  }
  return out;
}

std::vector<TimedFile> times(const Entry& layer, const Entry& list, const fs::path& folder) {
  if (find(layer, "source") != nullptr) complain(list.where, "a layer has either 'source' or 'times'");
  const std::string type = textAt(layer, "type").value_or("");
  if (list.shape != Entry::Shape::list || list.parts.empty() || list.parts.size() > kMostTimes)
    complain(list.where, fmt::format("'times' must be a list of 1 to {} of [\"TIME\", \"FILE\"]", kMostTimes));
  std::vector<TimedFile> out;
  for (const Entry& pair : list.parts) {
    if (pair.shape != Entry::Shape::list || pair.parts.size() != 2)
      complain(pair.where, "each of 'times' must be [\"TIME\", \"FILE\"]");
    TimedFile file{.time_s = asTime_s(pair.parts[0]), .source = sourceAt(pair.parts[1], folder)};
    file.from = kindOfSource(layer, type, file.source);
    if (file.from == SourceKind::service) complain(pair.where, "'times' is a list of files of this machine");
    expectFile(pair, file.source, "imagery", folder);
    if (!out.empty() && file.time_s <= out.back().time_s) complain(pair.where, "'times' must ascend");
    out.push_back(std::move(file));
  }
  return out;
}

}  // namespace

ElevationLayer readElevation(const Entry& layer, const fs::path& folder) {
  allow(layer, withServiceKeys({"source", "type", "seam_m"}));
  LayerSourceEntry from = readSource(layer, "elevation", false, folder);
  ElevationLayer out{.source = std::move(from.source), .from = from.from, .service = std::move(from.service)};
  if (const Entry* entry = find(layer, "seam_m")) out.seam_m = asNumber(*entry, 0.0, 1e7);
  if (out.service.time == kClockTime)
    complain(find(layer, "time")->where, "heights do not follow the clock; give one time, or take 'time' out");
  return out;
}

ImageryLayer readImagery(const Entry& layer, const Scene& scene, const fs::path& folder) {
  const std::string type = textAt(layer, "type").value_or("");
  if (type == "hillshade" || type == "slope" || type == "palette") return derivedImagery(layer, type, scene, folder);
  allow(layer, withServiceKeys({"source", "type", "name", "role", "times", "visible", "opacity", "blend", "brightness",
                                "contrast", "saturation", "gamma"}));
  ImageryLayer out;
  out.name = textAt(layer, "name").value_or("");
  out.look = look(layer);
  if (const Entry* entry = find(layer, "times")) {
    out.times = times(layer, *entry, folder);
  } else {
    LayerSourceEntry from = readSource(layer, "imagery", true, folder);
    out.source = std::move(from.source);
    out.from = from.from;
    out.service = std::move(from.service);
    out.alsoFrom = std::move(from.alsoFrom);
  }
  if (const Entry* entry = find(layer, "role")) {
    const std::string role = asText(*entry);
    if (role == "night_lights") {
      out.look.role = LayerRole::nightLights;
    } else if (role == "water") {
      out.look.role = LayerRole::water;
    } else if (role != "colour") {
      complain(entry->where, fmt::format("no role '{}'; allowed: colour, night_lights, water", role));
    }
  }
  return out;
}

}  // namespace tellurion::scene
