#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "io/failure.h"

namespace tellurion::scene {

/// What a viewer does as it did when it was closed last. What is seen (light, layers, time) is the scene's and not
/// here.
struct ViewerMemory {
  struct Size {
    int width = 0;
    int height = 0;
    friend bool operator==(const Size&, const Size&) = default;
  };
  std::optional<Size> window;  ///< in the window system's units
  bool layers = false;         ///< panels that are open
  bool settings = false;
  bool statistics = false;
  bool hasHint = false;  ///< the first hint was shown

  friend bool operator==(const ViewerMemory&, const ViewerMemory&) = default;
};

/// TOML: `window` = [width, height], `panels` = a list of "layers", "settings", "statistics", `hint` = whether it was
/// shown. Fails naming the place in the file. where: for messages.
io::Result<ViewerMemory> parseViewerMemory(std::string_view text, const std::string& where);
std::string formatViewerMemory(const ViewerMemory& memory);

}  // namespace tellurion::scene
