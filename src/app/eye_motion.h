#pragma once

#include <functional>

#include "app/view_input.h"
#include "scene/camera_path.h"
#include "scene/navigation.h"

// What moves the eye by itself for a while: flights, a zoom that eases out, a drag that goes on.
namespace tellurion::app {

/// A function of the seconds since it began; it ends at the latest there where it is no longer asked for.
struct EyeMotion {
  double begin_s = 0.0;
  double duration_s = 0.0;
  std::function<scene::View(double seconds, const scene::Ground&)> viewAt;
  double zoomSteps = 0.0;  ///< of a zoom, in all

  /// What is left of a zoom.
  double stepsLeft(double now_s) const;
};

EyeMotion flightTo(const scene::View& from, const scene::View& to, const scene::Ground& ground, double now_s);
/// Towards the grip, or straight up and down without one.
EyeMotion easedZoom(const scene::View& from, const std::optional<scene::Grip>& grip, double steps, double now_s);
/// From its first key to its last one.
EyeMotion alongPath(scene::CameraPath path, const scene::View& like, double now_s);

}  // namespace tellurion::app
