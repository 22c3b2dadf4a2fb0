#include "scene/scene_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "raster/service_url.h"
#include "raster/time_extent.h"
#include "scene/air_entry.h"
#include "scene/layer_entry.h"
#include "scene/scene_setting.h"

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;
using Words = std::vector<std::string_view>;

/// Of a layer that is a service, besides source and type.
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
constexpr double kFastestClock = 1e11;     ///< scene seconds a second
constexpr std::size_t kMostTimes = 10000;  ///< of a layer
constexpr std::size_t kMostStops = 1000;   ///< of a ramp of colours

/// What a scene file's reader throws within this file; it leaves as a value.
struct Wrong {
  io::Failure failure;
};

class SceneReader {
 public:
  explicit SceneReader(const std::string& path) : path_(path), folder_(fs::path(path).parent_path()) {}

  /// As if the file said so. Values are TOML; what is not, is a text.
  void set(toml::table& root, const Setting& setting) {
    toml::table* at = &root;
    std::string_view list;
    for (std::size_t i = 0; i + 1 < setting.path.size(); ++i) {
      const std::string& key = setting.path[i];
      toml::node* node = list.empty() ? at->get(key) : layerOf(*at, list, key, setting);
      if (node == nullptr) node = &put(*at, key, "{}", setting);
      list = list.empty() && node->is_array() ? std::string_view(key) : std::string_view();
      if (!list.empty()) continue;
      at = node->as_table();
      if (at == nullptr) complainOf(setting, fmt::format("'{}' of the scene has nothing in it that could be set", key));
    }
    const std::string value = isPlainValue(setting.value) ? setting.value : tomlText(setting.value);
    textsSet_[&put(*at, setting.path.back(), value, setting)] = setting.value;
  }

  /// base: what keys that are left out mean.
  Scene read(const toml::table& root, Scene scene) const {
    allow(root, {"name", "body", "tiling", "elevation", "imagery", "light", "atmosphere", "background", "clock"});
    scene.name = stringAt(root, "name").value_or(scene.name.empty() ? path_ : scene.name);
    if (const auto* node = root.get("body")) scene.body = body(*node);
    if (const auto* node = root.get("tiling")) scene.tiling = tilingNamed(*node);
    for (const toml::table* layer : tablesAt(root, "elevation"))
      scene.elevation.push_back(elevation(*layer));
    for (const toml::table* layer : tablesAt(root, "imagery"))
      scene.imagery.push_back(imagery(*layer, scene));
    if (const auto* node = root.get("light")) scene.lighting = light(table(*node, "light"));
    if (const auto* node = root.get("atmosphere")) scene.air = air(table(*node, "atmosphere"), scene.body);
    if (const auto* node = root.get("clock")) scene.clock = clock(table(*node, "clock"));
    if (const auto* node = root.get("background")) scene.background = colour(*node);
    return scene;
  }

 private:
  static std::string whereOf(const Setting& setting) { return "--set " + setting.written; }

  [[noreturn]] static void complainOf(const Setting& setting, std::string message) {
    throw Wrong{{.code = Code::invalidArgument, .message = std::move(message), .where = whereOf(setting)}};
  }

  toml::node* layerOf(toml::table& root, std::string_view list, std::string_view which, const Setting& setting) const {
    std::vector<LayerNames> layers;
    for (const toml::table* layer : tablesAt(root, list)) {
      const auto text = [&](std::string_view key) { return (*layer)[key].value_or(std::string()); };
      layers.push_back({.name = text("name"), .source = text("source"), .layer = text("layer")});
      const bool isDerived = layers.back().name.empty() && layers.back().source.empty();
      if (isDerived) layers.back().name = text("type");
    }
    const auto meant = layerMeant(which, layers);
    if (!meant) complainOf(setting, meant.error().message);
    return root.get(list)->as_array()->get(*meant);
  }

  /// What is put into the scene has the setting as its place, for messages.
  static toml::node& put(toml::table& table, std::string_view key, const std::string& value, const Setting& setting) {
    toml::table parsed = toml::parse("value = " + value, whereOf(setting));
    const toml::key placed(key, toml::source_region(parsed.begin()->first.source()));
    return parsed.get("value")->visit(
        [&](auto& typed) -> toml::node& { return table.insert_or_assign(placed, std::move(typed)).first->second; });
  }

  static bool isPlainValue(const std::string& text) {
    try {
      const toml::table parsed = toml::parse("value = " + text);
      const toml::node* value = parsed.size() == 1 ? parsed.get("value") : nullptr;
      return value != nullptr && !value->is_date() && !value->is_date_time() && !value->is_time();
    } catch (const toml::parse_error&) {
      return false;
    }
  }

  std::string placeOf(const toml::source_region& at) const {
    const bool isSet = at.path && *at.path != path_;
    return isSet ? *at.path : fmt::format("{}:{}:{}", path_, at.begin.line, at.begin.column);
  }

  [[noreturn]] void complain(const toml::source_region& at, std::string message,
                             Code code = Code::invalidArgument) const {
    throw Wrong{{.code = code, .message = std::move(message), .where = placeOf(at)}};
  }

  void allow(const toml::table& table, const Words& keys) const {
    for (const auto& [key, value] : table) {
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) {
        complain(key.source(), fmt::format("unknown key '{}'; allowed here: {}", key.str(), fmt::join(keys, ", ")));
      }
    }
  }

  static Words withServiceKeys(Words keys) {
    keys.insert(keys.end(), kServiceKeys.begin(), kServiceKeys.end());
    return keys;
  }

  const toml::table& table(const toml::node& node, std::string_view key) const {
    if (!node.is_table()) complain(node.source(), fmt::format("'{}' must be a table", key));
    return *node.as_table();
  }

  std::vector<const toml::table*> tablesAt(const toml::table& root, std::string_view key) const {
    std::vector<const toml::table*> out;
    const toml::node* node = root.get(key);
    if (node == nullptr) return out;
    if (!node->is_array()) complain(node->source(), fmt::format("layers are written as [[{}]], one for each", key));
    for (const toml::node& layer : *node->as_array())
      out.push_back(&table(layer, key));
    return out;
  }

  std::string string(const toml::node& node, std::string_view key) const {
    if (node.is_string()) return node.as_string()->get();
    const auto set = textsSet_.find(&node);
    if (set == textsSet_.end()) complain(node.source(), fmt::format("'{}' must be a text in quotes", key));
    return set->second;
  }
  std::optional<std::string> stringAt(const toml::table& table, std::string_view key) const {
    const toml::node* node = table.get(key);
    return node != nullptr ? std::optional(string(*node, key)) : std::nullopt;
  }

  double number(const toml::node& node, std::string_view key, double low, double high) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value || !(*value >= low && *value <= high)) {
      complain(node.source(), fmt::format("'{}' must be a number from {} to {}", key, low, high));
    }
    return *value;
  }
  double numberAt(const toml::table& table, std::string_view key, double low, double high, double otherwise) const {
    const toml::node* node = table.get(key);
    return node != nullptr ? number(*node, key, low, high) : otherwise;
  }

  bool boolAt(const toml::table& table, std::string_view key, bool otherwise) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return otherwise;
    if (!node->is_boolean()) complain(node->source(), fmt::format("'{}' must be true or false", key));
    return node->as_boolean()->get();
  }

  geo::Body body(const toml::node& node) const {
    constexpr std::string_view kAllowed =
        "allowed: \"earth\", \"mars\", \"moon\", { semi_major_axis_m = ..., inverse_flattening = ... }";
    if (node.is_string()) {
      const auto named = geo::bodyByName(node.as_string()->get());
      if (!named) complain(node.source(), fmt::format("no body '{}'; {}", node.as_string()->get(), kAllowed));
      return *named;
    }
    if (!node.is_table()) complain(node.source(), fmt::format("'body' is of the wrong type; {}", kAllowed));
    const toml::table& fields = *node.as_table();
    allow(fields, {"name", "semi_major_axis_m", "inverse_flattening"});
    if (fields.get("semi_major_axis_m") == nullptr) complain(node.source(), "a body needs semi_major_axis_m");
    const double axis_m = numberAt(fields, "semi_major_axis_m", 1.0, 1e12, 0.0);
    double flattening = 0.0;
    if (const toml::node* inverse = fields.get("inverse_flattening")) {
      const double value = number(*inverse, "inverse_flattening", 0.0, 1e12);
      if (value != 0.0 && value < 2.0) {
        complain(inverse->source(), "'inverse_flattening' must be at least 2, or 0 for a sphere");
      }
      flattening = value > 0.0 ? 1.0 / value : 0.0;
    }
    return {.name = stringAt(fields, "name").value_or("own"), .ellipsoid = geo::Ellipsoid(axis_m, flattening)};
  }

  tiling::Scheme tilingNamed(const toml::node& node) const {
    const std::string name = string(node, "tiling");
    const auto scheme = tiling::schemeByName(name);
    if (!scheme) complain(node.source(), fmt::format("no tiling '{}'; allowed: geographic, cube, healpix", name));
    return *scheme;
  }

  /// Where the layer's data come from: `out` is of any kind of layer.
  template <class Layer>
  void readSource(const toml::table& layer, std::string_view kind, Layer& out) const {
    const toml::node* node = layer.get("source");
    if (node == nullptr) complain(layer.source(), "the layer has no source");
    const toml::array* several = nullptr;
    if constexpr (requires { out.alsoFrom; }) several = node->as_array();
    if (several != nullptr && several->empty()) complain(node->source(), "the layer's list of sources is empty");
    out.source = sourceAt(several != nullptr ? *several->get(0) : *node);
    const std::string type = stringAt(layer, "type").value_or("");
    out.from = kindOfSource(layer, type, out.source);
    if constexpr (requires { out.alsoFrom; }) {
      if (several != nullptr && several->size() > 1) readFurther(*several, kind, type, out);
    }
    if (out.from == SourceKind::service) {
      out.service = service(layer, out.source, type);
      return;
    }
    for (const auto& [key, value] : layer) {
      if (std::find(kServiceKeys.begin(), kServiceKeys.end(), key.str()) != kServiceKeys.end())
        complain(key.source(), fmt::format("'{}' is for layers of services; say which with type", key.str()));
    }
    if (isServiceUrl(out.source))
      complain(node->source(),
               fmt::format("{}: type = \"{}\" is for files of this machine", raster::withoutSecrets(out.source), type));
    std::error_code error;
    if (!fs::exists(out.source, error)) complain(node->source(), absence(out.source, kind), Code::notFound);
  }

  std::string sourceAt(const toml::node& node) const {
    const std::string text = string(node, "source");
    if (isServiceUrl(text)) return text;
    const fs::path path(text);
    return (path.is_absolute() ? path : folder_ / path).string();
  }

  /// All but the first of a list of sources.
  void readFurther(const toml::array& several, std::string_view kind, const std::string& type,
                   ImageryLayer& out) const {
    for (std::size_t i = 0; i < several.size(); ++i) {
      const toml::node& node = *several.get(i);
      const std::string source = sourceAt(node);
      if (out.from == SourceKind::service || (type.empty() && sourceKindOf(source) == SourceKind::service))
        complain(node.source(), "a list of sources is of files; make the layer of a server one of its own");
      std::error_code error;
      if (!fs::exists(source, error)) complain(node.source(), absence(source, kind), Code::notFound);
      if (i > 0) out.alsoFrom.push_back(source);
    }
  }

  SourceKind kindOfSource(const toml::table& layer, const std::string& type, const std::string& source) const {
    if (type.empty()) return sourceKindOf(source);
    if (type == "live") return SourceKind::live;
    if (type == "catalogue") return SourceKind::catalogue;
    const Words services{"wms", "wmts", "tms", "xyz", "worldwind"};
    if (std::find(services.begin(), services.end(), type) == services.end()) {
      complain(layer.get("type")->source(),
               fmt::format("no type '{}'; allowed: {}, live, catalogue; of imagery also hillshade, slope, palette",
                           type, fmt::join(services, ", ")));
    }
    return SourceKind::service;
  }

  raster::ServiceLayer service(const toml::table& layer, const std::string& source, const std::string& type) const {
    const auto text = [&](std::string_view key) { return stringAt(layer, key).value_or(""); };
    const auto real = [&](std::string_view key, double low, double high) {
      const toml::node* node = layer.get(key);
      return node != nullptr ? std::optional(number(*node, key, low, high)) : std::nullopt;
    };
    const auto whole = [&](std::string_view key, int low, int high) -> std::optional<int> {
      const toml::node* node = layer.get(key);
      if (node == nullptr) return std::nullopt;
      const auto value = node->is_integer() ? node->value<int>() : std::nullopt;
      if (!value || *value < low || *value > high)
        complain(node->source(), fmt::format("'{}' must be a whole number from {} to {}", key, low, high));
      return value;
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
    if (const toml::node* node = layer.get("bounds")) out.bounds_degrees = bounds(*node);
    return out;
  }

  std::array<double, 4> bounds(const toml::node& node) const {
    const toml::array* sides = node.as_array();
    if (sides == nullptr || sides->size() != 4)
      complain(node.source(), "'bounds' must be [west, south, east, north] in degrees");
    std::array<double, 4> out{};
    for (std::size_t i = 0; i < 4; ++i)
      out[i] = number(*sides->get(i), "bounds", i % 2 == 0 ? -540.0 : -90.0, i % 2 == 0 ? 540.0 : 90.0);
    if (out[1] >= out[3]) complain(node.source(), "'bounds' must have the south below the north");
    return out;
  }

  std::string absence(const fs::path& path, std::string_view kind) const {
    std::string text = fmt::format("there is no file {}", path.string());
    if (path.extension() != ".tdb") return text;
    text += fmt::format("; build it: tellurion build {} INPUT... --kind {}", path.string(), kind);
    std::error_code error;
    if (fs::exists(folder_ / "demo.sh", error)) text += "; or './bootstrap demo' makes all that the demo's scenes need";
    return text;
  }

  ElevationLayer elevation(const toml::table& layer) const {
    allow(layer, withServiceKeys({"source", "type", "seam_m"}));
    ElevationLayer out;
    readSource(layer, "elevation", out);
    if (const toml::node* node = layer.get("seam_m")) out.seam_m = number(*node, "seam_m", 0.0, 1e7);
    if (out.service.time == kClockTime)
      complain(layer.get("time")->source(), "heights do not follow the clock; give one time, or take 'time' out");
    return out;
  }

  ImageryLayer imagery(const toml::table& layer, const Scene& scene) const {
    const std::string type = stringAt(layer, "type").value_or("");
    if (type == "hillshade" || type == "slope" || type == "palette") return derivedImagery(layer, type, scene);
    allow(layer, withServiceKeys({"source", "type", "name", "role", "times", "visible", "opacity", "blend",
                                  "brightness", "contrast", "saturation", "gamma"}));
    ImageryLayer out;
    out.name = stringAt(layer, "name").value_or("");
    out.look = look(layer);
    if (const toml::node* node = layer.get("times")) {
      out.times = times(layer, *node);
    } else {
      readSource(layer, "imagery", out);
    }
    if (const toml::node* node = layer.get("role")) {
      const std::string role = string(*node, "role");
      if (role != "colour" && role != "night_lights") {
        complain(node->source(), fmt::format("no role '{}'; allowed: colour, night_lights", role));
      }
      out.look.nightLights = role == "night_lights";
    }
    return out;
  }

  /// A picture of the heights that are known so far.
  ImageryLayer derivedImagery(const toml::table& layer, const std::string& type, const Scene& scene) const {
    Words keys{"type",
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
    out.name = stringAt(layer, "name").value_or(type);
    out.look = look(layer);
    out.derived.emplace();
    const double exaggeration = numberAt(layer, "exaggeration", 0.0, 100.0, 1.0);
    if (type == "hillshade") {
      const auto angle = [&](std::string_view key, double low, double high, geo::Angle otherwise) {
        return geo::Angle::degrees(numberAt(layer, key, low, high, otherwise.degrees()));
      };
      const raster::Hillshade usual;
      out.derived->colours = raster::Hillshade{.sunAzimuth = angle("sun_azimuth", -360.0, 360.0, usual.sunAzimuth),
                                               .sunAltitude = angle("sun_altitude", 0.0, 90.0, usual.sunAltitude),
                                               .exaggeration = exaggeration};
    } else if (type == "slope") {
      out.derived->colours = raster::SlopeColours{.stops = stops(layer, {}), .exaggeration = exaggeration};
    } else {
      out.derived->colours = raster::Palette{stops(layer, scene.body.name)};
    }
    if (const toml::node* node = layer.get("of")) {
      out.derived->of = heightsOf(*node);
    } else if (scene.elevation.empty()) {
      complain(layer.source(), fmt::format("a {} is made of heights; give the scene an [[elevation]] layer, or the "
                                           "layer a source of them with of = \"FILE\"",
                                           type));
    }
    return out;
  }

  /// A path or URL, or a table like one of [[elevation]].
  ElevationLayer heightsOf(const toml::node& node) const {
    if (node.is_table()) return elevation(*node.as_table());
    ElevationLayer out;
    out.source = sourceAt(node);
    out.from = sourceKindOf(out.source);
    std::error_code error;
    if (out.from == SourceKind::service) {
      out.service.source = out.source;
    } else if (!fs::exists(out.source, error)) {
      complain(node.source(), absence(out.source, "elevation"), Code::notFound);
    }
    return out;
  }

  /// Of slopes (no body), or of the heights of a body.
  std::vector<raster::ColourStop> stops(const toml::table& layer, std::string_view body) const {
    const toml::node* node = layer.get("stops");
    const bool isOfHeights = !body.empty();
    const bool isNamed = isOfHeights && (node == nullptr || node->is_string());
    if (!isNamed && node != nullptr) return stopsIn(*node, isOfHeights ? 1e7 : 90.0);
    const std::string name = node != nullptr ? string(*node, "stops") : std::string(body);
    const auto ramp = isOfHeights ? raster::heightRamp(name) : raster::slopeRamp();
    if (ramp.empty()) {
      complain(node != nullptr ? node->source() : layer.source(),
               fmt::format("no palette '{}'; 'stops' may be \"earth\", \"mars\", \"moon\" or "
                           "[[height_m, \"RRGGBB\"], ...]",
                           name));
    }
    return {ramp.begin(), ramp.end()};
  }

  std::vector<raster::ColourStop> stopsIn(const toml::node& node, double largest) const {
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty() || list->size() > kMostStops) {
      complain(node.source(), fmt::format("'stops' must be a list of 1 to {} of [number, \"RRGGBB\"]", kMostStops));
    }
    std::vector<raster::ColourStop> out;
    for (const toml::node& each : *list) {
      const toml::array* stop = each.as_array();
      if (stop == nullptr || stop->size() != 2) complain(each.source(), "each of 'stops' must be [number, \"RRGGBB\"]");
      const double value = number(*stop->get(0), "stops", -largest, largest);
      if (!out.empty() && value < out.back().value) complain(each.source(), "'stops' must ascend");
      const auto rgb = hexColour(*stop->get(1), "stops");
      out.push_back({.value = value, .colour = {rgb[0], rgb[1], rgb[2], 255}});
    }
    return out;
  }

  double time(const toml::node& node, std::string_view key) const {
    const auto seconds = raster::secondsOfTime(string(node, key));
    if (!seconds) complain(node.source(), fmt::format("'{}' must be a time like \"2004-01-31T12:00:00Z\"", key));
    return *seconds;
  }

  SceneClock clock(const toml::table& fields) const {
    allow(fields, {"start", "end", "rate", "step"});
    SceneClock out;
    if (const toml::node* node = fields.get("start")) out.start_s = time(*node, "start");
    if (const toml::node* node = fields.get("end")) out.end_s = time(*node, "end");
    out.rate = numberAt(fields, "rate", -kFastestClock, kFastestClock, out.rate);
    out.step_s = numberAt(fields, "step", 1e-3, kFastestClock, out.step_s);
    return out;
  }

  std::vector<TimedFile> times(const toml::table& layer, const toml::node& node) const {
    if (layer.get("source") != nullptr) complain(node.source(), "a layer has either 'source' or 'times'");
    const std::string type = stringAt(layer, "type").value_or("");
    const toml::array* list = node.as_array();
    if (list == nullptr || list->empty() || list->size() > kMostTimes)
      complain(node.source(), fmt::format("'times' must be a list of 1 to {} of [\"TIME\", \"FILE\"]", kMostTimes));
    std::vector<TimedFile> out;
    for (const toml::node& each : *list) {
      const toml::array* pair = each.as_array();
      if (pair == nullptr || pair->size() != 2) complain(each.source(), "each of 'times' must be [\"TIME\", \"FILE\"]");
      TimedFile file{.time_s = time(*pair->get(0), "times"), .source = sourceAt(*pair->get(1))};
      file.from = kindOfSource(layer, type, file.source);
      if (file.from == SourceKind::service) complain(each.source(), "'times' is a list of files of this machine");
      std::error_code error;
      if (!fs::exists(file.source, error)) complain(each.source(), absence(file.source, "imagery"), Code::notFound);
      if (!out.empty() && file.time_s <= out.back().time_s) complain(each.source(), "'times' must ascend");
      out.push_back(std::move(file));
    }
    return out;
  }

  LayerLook look(const toml::table& layer) const {
    LayerLook out;
    const auto adjustment = [&](std::string_view key, double least) {
      return numberAt(layer, key, least, kMostAdjustment, 1.0);
    };
    out.visible = boolAt(layer, "visible", true);
    out.opacity = numberAt(layer, "opacity", 0.0, 1.0, 1.0);
    out.brightness = adjustment("brightness", 0.0);
    out.contrast = adjustment("contrast", 0.0);
    out.saturation = adjustment("saturation", 0.0);
    out.gamma = adjustment("gamma", kLeastGamma);
    if (const toml::node* node = layer.get("blend")) {
      const std::string name = string(*node, "blend");
      const auto mode = blendModeByName(name);
      if (!mode)
        complain(node->source(),
                 fmt::format("no blend mode '{}'; allowed: normal, multiply, screen, add, overlay", name));
      out.blend = *mode;
    }
    return out;
  }

  Lighting light(const toml::table& fields) const {
    allow(fields, {"enabled", "sun", "ambient"});
    Lighting out;
    out.enabled = boolAt(fields, "enabled", out.enabled);
    out.ambient = numberAt(fields, "ambient", 0.0, 1.0, out.ambient);
    const toml::node* sun = fields.get("sun");
    if (sun == nullptr) return out;
    const toml::array* place = sun->as_array();
    if (place != nullptr && place->size() == 2) {
      out.sun = Lighting::Sun::fixed;
      out.subsolar = geo::directionFromDegrees(number(*place->get(0), "sun", -90.0, 90.0),
                                               number(*place->get(1), "sun", -360.0, 360.0));
      return out;
    }
    const std::string_view word = sun->is_string() ? std::string_view(sun->as_string()->get()) : "";
    if (word == "clock") {
      out.sun = Lighting::Sun::byClock;
    } else if (word != "camera") {
      complain(
          sun->source(),
          "'sun' must be \"camera\", \"clock\" or [latitude, longitude] of where it stands in the zenith, degrees");
    }
    return out;
  }

  Air air(const toml::table& table, const geo::Body& body) const {
    std::vector<EntryField> fields;
    for (const auto& [key, value] : table) {
      EntryField& field = fields.emplace_back(EntryField{std::string(key.str()), {}, placeOf(value.source())});
      if (value.is_boolean()) field.value = value.as_boolean()->get();
      if (value.is_number()) field.value = *value.value<double>();
      if (value.is_string()) field.value = value.as_string()->get();
      if (const toml::array* list = value.as_array()) {
        const auto isNumber = [](const toml::node& node) { return node.is_number(); };
        if (!std::ranges::all_of(*list, isNumber)) continue;
        std::vector<double>& numbers = field.value.emplace<std::vector<double>>();
        for (const toml::node& number : *list)
          numbers.push_back(*number.value<double>());
      }
    }
    auto air = readAir(fields, placeOf(table.source()), body);
    if (!air) throw Wrong{std::move(air.error())};
    return *air;
  }

  std::array<float, 3> colour(const toml::node& node) const {
    const auto rgb = hexColour(node, "background");
    return {rgb[0] / 255.0f, rgb[1] / 255.0f, rgb[2] / 255.0f};
  }

  /// "RRGGBB", with or without a "#" before it.
  std::array<std::uint8_t, 3> hexColour(const toml::node& node, std::string_view key) const {
    std::string text = string(node, key);
    if (text.starts_with('#')) text.erase(0, 1);
    const bool isHex = text.size() == 6 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
    if (!isHex) complain(node.source(), fmt::format("'{}' must be a colour \"RRGGBB\" in hexadecimal digits", key));
    std::array<std::uint8_t, 3> out{};
    for (std::size_t i = 0; i < 3; ++i)
      out[i] = static_cast<std::uint8_t>(std::stoul(text.substr(2 * i, 2), nullptr, 16));
    return out;
  }

  std::string path_;
  fs::path folder_;
  std::map<const toml::node*, std::string> textsSet_;  ///< what was set, as it is written: 101820 may be a colour
};

}  // namespace

io::Result<Scene> parseScene(std::string_view text, const std::string& path, std::span<const std::string> settings,
                             Scene base) {
  try {
    toml::table root = toml::parse(text, path);
    SceneReader reader(path);
    for (const std::string& written : settings) {
      const auto setting = parseSetting(written);
      if (!setting) return tl::unexpected(setting.error());
      reader.set(root, *setting);
    }
    return reader.read(root, std::move(base));
  } catch (const toml::parse_error& e) {
    const auto at = e.source().begin;
    return io::fail(Code::invalidArgument, std::string(e.description()),
                    fmt::format("{}:{}:{}", path, at.line, at.column));
  } catch (Wrong& wrong) {
    return tl::unexpected(std::move(wrong.failure));
  }
}

}  // namespace tellurion::scene
