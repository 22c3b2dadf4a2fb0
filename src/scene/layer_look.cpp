#include "scene/layer_look.h"

namespace tellurion::scene {

const char* nameOf(BlendMode mode) {
  switch (mode) {
    case BlendMode::normal:
      return "normal";
    case BlendMode::multiply:
      return "multiply";
    case BlendMode::screen:
      return "screen";
    case BlendMode::add:
      return "add";
    case BlendMode::overlay:
      return "overlay";
  }
  return "normal";
}

std::optional<BlendMode> blendModeByName(std::string_view name) {
  for (const BlendMode mode : kBlendModes) {
    if (name == nameOf(mode)) return mode;
  }
  return std::nullopt;
}

}  // namespace tellurion::scene
