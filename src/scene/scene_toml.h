#pragma once

#include <span>
#include <string>
#include <string_view>

#include "scene/entry.h"

namespace tellurion::scene {

/// The table that a scene file's text is, as if it said what the settings say (scene_setting.h). path: for messages.
/// Fails where the text is no TOML (where: path:line:column), and where a setting has no place in it.
io::Result<Entry> readToml(std::string_view text, const std::string& path, std::span<const std::string> settings);

}  // namespace tellurion::scene
