#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace tellurion::scene {

/// How a layer's colour C meets the ground G under it. All in linear light, 0..1.
enum class BlendMode {
  normal,    ///< C
  multiply,  ///< C G
  screen,    ///< 1 - (1 - C) (1 - G)
  add,       ///< C + G, at most 1
  overlay,   ///< 2 C G where G is at most 1/2, else 1 - 2 (1 - C) (1 - G)
};
inline constexpr std::array kBlendModes{BlendMode::normal, BlendMode::multiply, BlendMode::screen, BlendMode::add,
                                        BlendMode::overlay};

/// As scene files name it.
const char* nameOf(BlendMode mode);
std::optional<BlendMode> blendModeByName(std::string_view name);

inline constexpr double kMostAdjustment = 10.0;  ///< of brightness, contrast, saturation and gamma
inline constexpr double kLeastGamma = 0.1;

/// What a layer's pictures are of.
enum class LayerRole {
  colour,
  nightLights,  ///< shown where the sun is below the horizon, added to the ground
  water,        ///< where there is water, which mirrors the sun
};

/// How an imagery layer is shown (docs/rendering.md has the formulas). Plain data: changing it asks no source for
/// anything.
struct LayerLook {
  bool visible = true;
  double opacity = 1.0;  ///< 0..1, multiplies the coverage; of night lights and water their brightness
  BlendMode blend = BlendMode::normal;
  // In this order, in linear light; each does nothing at 1. 0..kMostAdjustment, gamma from kLeastGamma.
  double brightness = 1.0;  ///< multiplies the light
  double contrast = 1.0;    ///< multiplies the distance to middle grey (sRGB 0.5)
  double saturation = 1.0;  ///< multiplies the distance to the grey of the same luminance
  double gamma = 1.0;       ///< the light is raised to 1 / gamma: above 1 dark colours become lighter
  /// Of all but colour, opacity and brightness count. Stays what it was when the layer was opened.
  LayerRole role = LayerRole::colour;

  bool adjusts() const { return brightness != 1.0 || contrast != 1.0 || saturation != 1.0 || gamma != 1.0; }
};

}  // namespace tellurion::scene
