#pragma once

#include <cmath>
#include <optional>

#include "scene/frame.h"

namespace tellurion::render {

/// The Moon as the eye sees it.
struct MoonDisc {
  geo::Vec3 towards_body{0.0, 0.0, 1.0};  ///< unit vector from the eye
  double radius_rad = 0.0;
};

/// Nothing where the frame has no Moon, or the eye is inside it.
inline std::optional<MoonDisc> moonDiscOf(const scene::Frame& frame) {
  constexpr double kMoonRadius_m = 1737.4e3;
  if (!frame.sky.moon_m) return std::nullopt;
  const geo::Vec3 from_m = *frame.sky.moon_m - frame.view.eye.m;
  const double distance_m = geo::length(from_m);
  if (distance_m <= kMoonRadius_m) return std::nullopt;
  return MoonDisc{.towards_body = from_m / distance_m, .radius_rad = std::asin(kMoonRadius_m / distance_m)};
}

}  // namespace tellurion::render
