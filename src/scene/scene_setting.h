#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/failure.h"

namespace tellurion::scene {

/// A value of a scene file that is given elsewhere: "KEY=VALUE".
struct Setting {
  std::string written;            ///< all of it
  std::vector<std::string> path;  ///< the key's parts, none empty; of layers: list, which, key
  std::string value;              ///< as it is written: TOML, or a text without its quotes
};

/// The key is what stands before the first '=', parted by dots: "light.ambient", "background", "imagery.WHICH.opacity".
/// WHICH may have dots of its own.
io::Result<Setting> parseSetting(std::string_view text);

/// A text in quotes, as TOML has it.
std::string tomlText(std::string_view text);

/// What a layer may be called in a setting.
struct LayerNames {
  std::string name;
  std::string source;
  std::string layer;  ///< of a service
};

/// Index of the layer that `which` means: its place from 0, bottom first, or else its name, its source's file name,
/// with or without the ending, or its service's layer. Fails where that is none of them, or several.
io::Result<std::size_t> layerMeant(std::string_view which, std::span<const LayerNames> layers);

}  // namespace tellurion::scene
