#include "scene/scene_setting.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

namespace tellurion::scene {
namespace {

using Code = io::Failure::Code;

bool isListOfLayers(std::string_view key) {
  return key == "elevation" || key == "imagery";
}

std::vector<std::string> partsOf(std::string_view key) {
  std::vector<std::string> out;
  const auto first = key.find('.');
  const auto last = key.rfind('.');
  if (isListOfLayers(key.substr(0, first)) && last != first) {
    for (const auto part : {key.substr(0, first), key.substr(first + 1, last - first - 1), key.substr(last + 1)})
      out.emplace_back(part);
    return out;
  }
  for (;;) {
    const auto dot = key.find('.');
    out.emplace_back(key.substr(0, dot));
    if (dot == std::string_view::npos) return out;
    key.remove_prefix(dot + 1);
  }
}

bool isCalled(const LayerNames& layer, std::string_view which) {
  const std::filesystem::path source(layer.source);
  return which == layer.name || which == layer.layer || which == source.filename() || which == source.stem();
}

std::string listed(std::span<const LayerNames> layers) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const LayerNames& layer = layers[i];
    const std::string source = std::filesystem::path(layer.source).filename().string();
    const std::string& name = !layer.name.empty() ? layer.name : !layer.layer.empty() ? layer.layer : source;
    out.push_back(fmt::format("{} ({})", i, name));
  }
  return fmt::format("{}", fmt::join(out, ", "));
}

}  // namespace

io::Result<Setting> parseSetting(std::string_view text) {
  const auto equals = text.find('=');
  Setting out{.written = std::string(text), .path = partsOf(text.substr(0, equals)), .value = {}};
  const bool isWhole = equals != std::string_view::npos && !std::ranges::any_of(out.path, &std::string::empty);
  const bool lacksKey = isListOfLayers(out.path.front()) && out.path.size() != 3;
  if (!isWhole || lacksKey)
    return io::fail(Code::invalidArgument,
                    fmt::format("'{}' is not KEY=VALUE, like light.ambient=0.2 or imagery.0.opacity=0.5", text));
  out.value = text.substr(equals + 1);
  return out;
}

std::string tomlText(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || c == '"' || c == '\\') {
      out += fmt::format("\\u{:04X}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

io::Result<std::size_t> layerMeant(std::string_view which, std::span<const LayerNames> layers) {
  const auto unclear = [&](std::string_view what) {
    return io::fail(Code::invalidArgument, fmt::format("'{}' {}; the layers from the bottom: {}", which, what,
                                                       layers.empty() ? "none" : listed(layers)));
  };
  std::size_t place = 0;
  const auto number = std::from_chars(which.data(), which.data() + which.size(), place);
  if (number.ec == std::errc() && number.ptr == which.data() + which.size()) {
    if (place < layers.size()) return place;
    return unclear("is no layer's number");
  }
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (!isCalled(layers[i], which)) continue;
    if (found) return unclear("is the name of several layers, so use its number");
    found = i;
  }
  if (!found) return unclear("is no layer's name");
  return *found;
}

}  // namespace tellurion::scene
