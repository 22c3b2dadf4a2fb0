#include "scene/scene_file.h"

#include <fmt/format.h>

#include <filesystem>

#include "scene/air_entry.h"
#include "scene/layer_tables.h"
#include "scene/scene_toml.h"
#include "scene/sky_entry.h"

namespace tellurion::scene {
namespace {

constexpr double kFastestClock = 1e11;  ///< scene seconds a second

geo::Body readBody(const Entry& entry) {
  constexpr std::string_view kAllowed =
      "allowed: \"earth\", \"mars\", \"moon\", { semi_major_axis_m = ..., inverse_flattening = ... }";
  if (const auto* name = std::get_if<std::string>(&entry.value)) {
    const auto named = geo::bodyByName(*name);
    if (!named) complain(entry.where, fmt::format("no body '{}'; {}", *name, kAllowed));
    return *named;
  }
  if (entry.shape != Entry::Shape::table)
    complain(entry.where, fmt::format("'body' is of the wrong type; {}", kAllowed));
  allow(entry, {"name", "semi_major_axis_m", "inverse_flattening"});
  if (find(entry, "semi_major_axis_m") == nullptr) complain(entry.where, "a body needs semi_major_axis_m");
  const double axis_m = numberAt(entry, "semi_major_axis_m", 1.0, 1e12, 0.0);
  double flattening = 0.0;
  if (const Entry* inverse = find(entry, "inverse_flattening")) {
    const double value = asNumber(*inverse, 0.0, 1e12);
    if (value != 0.0 && value < 2.0)
      complain(inverse->where, "'inverse_flattening' must be at least 2, or 0 for a sphere");
    flattening = value > 0.0 ? 1.0 / value : 0.0;
  }
  return {.name = textAt(entry, "name").value_or("own"), .ellipsoid = geo::Ellipsoid(axis_m, flattening)};
}

tiling::Scheme readTiling(const Entry& entry) {
  const std::string name = asText(entry);
  const auto scheme = tiling::schemeByName(name);
  if (!scheme) complain(entry.where, fmt::format("no tiling '{}'; allowed: geographic, cube, healpix", name));
  return *scheme;
}

SceneClock readClock(const Entry& table) {
  allow(table, {"start", "end", "rate", "step"});
  SceneClock out;
  if (const Entry* entry = find(table, "start")) out.start_s = asTime_s(*entry);
  if (const Entry* entry = find(table, "end")) out.end_s = asTime_s(*entry);
  out.rate = numberAt(table, "rate", -kFastestClock, kFastestClock, out.rate);
  out.step_s = numberAt(table, "step", 1e-3, kFastestClock, out.step_s);
  return out;
}

Lighting readLight(const Entry& table) {
  allow(table, {"enabled", "sun", "ambient"});
  Lighting out;
  out.enabled = booleanAt(table, "enabled", out.enabled);
  out.ambient = numberAt(table, "ambient", 0.0, 1.0, out.ambient);
  const Entry* sun = find(table, "sun");
  if (sun == nullptr) return out;
  if (sun->shape == Entry::Shape::list && sun->parts.size() == 2) {
    out.sun = Lighting::Sun::fixed;
    out.subsolar =
        geo::directionFromDegrees(asNumber(sun->parts[0], -90.0, 90.0), asNumber(sun->parts[1], -360.0, 360.0));
    return out;
  }
  const std::string word = sun->isText() ? asText(*sun) : "";
  if (word == "clock") {
    out.sun = Lighting::Sun::byClock;
  } else if (word != "camera") {
    complain(sun->where,
             "'sun' must be \"camera\", \"clock\" or [latitude, longitude] of where it stands in the zenith, degrees");
  }
  return out;
}

std::array<float, 3> readBackground(const Entry& entry) {
  const auto rgb = asColour(entry);
  return {rgb[0] / 255.0f, rgb[1] / 255.0f, rgb[2] / 255.0f};
}

Scene readScene(const Entry& root, const std::string& path, Scene scene) {
  allow(root, {"name", "body", "tiling", "elevation", "imagery", "light", "atmosphere", "sky", "background", "clock"});
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  scene.name = textAt(root, "name").value_or(scene.name.empty() ? path : scene.name);
  if (const Entry* entry = find(root, "body")) scene.body = readBody(*entry);
  if (const Entry* entry = find(root, "tiling")) scene.tiling = readTiling(*entry);
  for (const Entry* layer : tablesAt(root, "elevation"))
    scene.elevation.push_back(readElevation(*layer, folder));
  for (const Entry* layer : tablesAt(root, "imagery"))
    scene.imagery.push_back(readImagery(*layer, scene, folder));
  if (const Entry* entry = find(root, "light")) scene.lighting = readLight(asTable(*entry));
  if (const Entry* entry = find(root, "atmosphere")) scene.air = readAir(asTable(*entry), scene.body);
  if (const Entry* entry = find(root, "sky")) scene.sky = readSky(asTable(*entry), folder);
  if (const Entry* entry = find(root, "clock")) scene.clock = readClock(asTable(*entry));
  if (const Entry* entry = find(root, "background")) scene.background = readBackground(*entry);
  return scene;
}

}  // namespace

io::Result<Scene> parseScene(std::string_view text, const std::string& path, std::span<const std::string> settings,
                             Scene base) {
  const auto root = readToml(text, path, settings);
  if (!root) return tl::unexpected(root.error());
  try {
    return readScene(*root, path, std::move(base));
  } catch (EntryFault& fault) {
    return tl::unexpected(std::move(fault.failure));
  }
}

}  // namespace tellurion::scene
