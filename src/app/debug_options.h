#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "app/studio.h"

namespace tellurion::app {

/// What `render` and `fly` are asked to show of how their pictures are made.
struct DebugOptions {
  std::string views;
  std::string freezeAt;
};

/// --debug and --freeze-at, checked as they are read: what is wrong is wrong use.
void addDebugOptions(CLI::App& command, DebugOptions& options);

/// Has the studio's pictures show it from the next update on.
io::Result<void> showDebug(const DebugOptions& options, const PictureArguments& picture, Studio& studio);

}  // namespace tellurion::app
