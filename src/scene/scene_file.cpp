#include "scene/scene_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <optional>

namespace tellurion::scene {
namespace {

namespace fs = std::filesystem;
using Code = io::Failure::Code;
using Words = std::initializer_list<std::string_view>;

/// What a scene file's reader throws within this file; it leaves as a value.
struct Wrong {
  io::Failure failure;
};

class SceneReader {
 public:
  explicit SceneReader(const std::string& path) : path_(path), folder_(fs::path(path).parent_path()) {}

  Scene read(const toml::table& root) const {
    allow(root, {"name", "body", "tiling", "elevation", "imagery", "light", "background"});
    Scene scene;
    scene.name = stringAt(root, "name").value_or(path_);
    if (const auto* node = root.get("body")) scene.body = body(*node);
    if (const auto* node = root.get("tiling")) scene.tiling = tilingNamed(*node);
    for (const toml::table* layer : tablesAt(root, "elevation"))
      scene.elevation.push_back(elevation(*layer));
    for (const toml::table* layer : tablesAt(root, "imagery"))
      scene.imagery.push_back(imagery(*layer));
    if (const auto* node = root.get("light")) scene.lighting = light(table(*node, "light"));
    if (const auto* node = root.get("background")) scene.background = colour(*node);
    return scene;
  }

 private:
  [[noreturn]] void complain(const toml::source_region& at, std::string message,
                             Code code = Code::invalidArgument) const {
    throw Wrong{{.code = code,
                 .message = std::move(message),
                 .where = fmt::format("{}:{}:{}", path_, at.begin.line, at.begin.column)}};
  }

  void allow(const toml::table& table, Words keys) const {
    for (const auto& [key, value] : table) {
      if (std::find(keys.begin(), keys.end(), key.str()) == keys.end()) {
        complain(key.source(), fmt::format("unknown key '{}'; allowed here: {}", key.str(), fmt::join(keys, ", ")));
      }
    }
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
    if (!node.is_string()) complain(node.source(), fmt::format("'{}' must be a text in quotes", key));
    return node.as_string()->get();
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

  std::string source(const toml::table& layer, std::string_view kind) const {
    const toml::node* node = layer.get("source");
    if (node == nullptr) complain(layer.source(), "the layer has no source");
    return sourceAt(*node, kind);
  }

  /// One source, or several in a list.
  std::vector<std::string> sources(const toml::table& layer, std::string_view kind) const {
    const toml::node* node = layer.get("source");
    if (node == nullptr || !node->is_array()) return {source(layer, kind)};
    if (node->as_array()->empty()) complain(node->source(), "the layer's list of sources is empty");
    std::vector<std::string> out;
    for (const toml::node& each : *node->as_array())
      out.push_back(sourceAt(each, kind));
    return out;
  }

  std::string sourceAt(const toml::node& at, std::string_view kind) const {
    const std::string text = string(at, "source");
    if (text.find("://") != std::string::npos) {
      complain(at.source(),
               fmt::format("{}: this version reads no online sources; copy the data here and name the file", text),
               Code::unsupported);
    }
    const fs::path path = fs::path(text).is_absolute() ? fs::path(text) : folder_ / text;
    std::error_code error;
    if (!fs::exists(path, error)) complain(at.source(), absence(path, kind), Code::notFound);
    return path.string();
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
    allow(layer, {"source"});
    return {.source = source(layer, "elevation")};
  }

  ImageryLayer imagery(const toml::table& layer) const {
    allow(layer,
          {"source", "name", "role", "visible", "opacity", "blend", "brightness", "contrast", "saturation", "gamma"});
    std::vector<std::string> from = sources(layer, "imagery");
    ImageryLayer out{.name = stringAt(layer, "name").value_or(""),
                     .source = from.front(),
                     .alsoFrom = {from.begin() + 1, from.end()},
                     .look = look(layer)};
    if (const toml::node* node = layer.get("role")) {
      const std::string role = string(*node, "role");
      if (role != "colour" && role != "night_lights") {
        complain(node->source(), fmt::format("no role '{}'; allowed: colour, night_lights", role));
      }
      out.look.nightLights = role == "night_lights";
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
        complain(node->source(), fmt::format("no blend mode '{}'; allowed: normal, multiply, screen, add", name));
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
    } else if (!(sun->is_string() && sun->as_string()->get() == "camera")) {
      complain(sun->source(),
               "'sun' must be \"camera\" or [latitude, longitude] of where it stands in the zenith, degrees");
    }
    return out;
  }

  std::array<float, 3> colour(const toml::node& node) const {
    const std::string text = string(node, "background");
    const bool isHex = text.size() == 6 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
    if (!isHex) complain(node.source(), "'background' must be a colour \"RRGGBB\" in hexadecimal digits");
    std::array<float, 3> out{};
    for (std::size_t i = 0; i < 3; ++i) {
      out[i] = static_cast<float>(std::stoul(text.substr(2 * i, 2), nullptr, 16)) / 255.0f;
    }
    return out;
  }

  std::string path_;
  fs::path folder_;
};

}  // namespace

io::Result<Scene> parseScene(std::string_view text, const std::string& path) {
  try {
    return SceneReader(path).read(toml::parse(text, path));
  } catch (const toml::parse_error& e) {
    const auto at = e.source().begin;
    return io::fail(Code::invalidArgument, std::string(e.description()),
                    fmt::format("{}:{}:{}", path, at.line, at.column));
  } catch (Wrong& wrong) {
    return tl::unexpected(std::move(wrong.failure));
  }
}

}  // namespace tellurion::scene
