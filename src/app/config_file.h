#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "io/failure.h"

// What the viewer remembers between runs: small text files in $XDG_CONFIG_HOME/tellurion, else ~/.config/tellurion.
namespace tellurion::app {

/// The path of a file there, which need not exist.
std::string configPath(std::string_view name);
/// Nothing: there is none. Fails where it cannot be read or is larger than a mebibyte.
io::Result<std::optional<std::string>> readConfig(std::string_view name);
/// As a whole or not at all; makes the folder.
io::Result<void> writeConfig(std::string_view name, std::string_view text);
/// Gives a file that cannot be understood another name, "NAME.damaged" or the next free one, which it returns.
std::string setAsideConfig(std::string_view name);

}  // namespace tellurion::app
