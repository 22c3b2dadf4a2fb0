#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/globe.h"

// What a window that leads others shows, for those that follow it (docs/several-machines.md).
namespace tellurion::scene {

/// All that a picture is of, but for the data and the screen. Plain data.
struct LedPicture {
  geo::BodyPosition eye;
  geo::Mat3 viewFromBody{1.0};
  geo::Angle verticalFov = geo::Angle::degrees(45.0);
  double cutTime_s = 0.0;         ///< CutOptions::time_s: by it late data fade in
  std::optional<double> clock_s;  ///< Globe::clock
  // Of CutOptions, at the quality in force.
  double tolerance_px = 1.0;
  double texelTolerance_px = 1.0;
  double maxSpacing_px = 0.0;
  bool morph = true;
  double exaggeration = 1.0;
  Lighting lighting;
  bool airEnabled = false;
  std::optional<double> exposure_stops;
  bool skyEnabled = false;
  double skyBrightness_stops = 0.0;
  bool discs = true;
  std::array<float, 3> background{};
  std::vector<LayerLook> looks;      ///< as Globe::imageryLooks has them, but for their roles
  std::vector<std::uint32_t> order;  ///< as Globe::imageryOrder
};

LedPicture ledPicture(Globe& globe, const View& view, const CutOptions& cut);

/// Makes the globe show it, and gives what to cut it by besides `own`, which keeps its budgets. Fails where the globe
/// has other layers.
io::Result<CutOptions> apply(const LedPicture& picture, Globe& globe, CutOptions own);
/// From its eye, on a screen of this size.
View viewOf(const LedPicture& picture, Viewport size);

/// Some 200 bytes, and 50 a layer.
std::string encode(const LedPicture& picture);
/// Safe on any bytes: fails where they are cut off, or anything in them is beyond what the program itself allows (not
/// finite, no rotation, layers more than 4096 or an order that leaves one out).
io::Result<LedPicture> decodeLedPicture(std::string_view bytes);

}  // namespace tellurion::scene
