#pragma once

#include <string>

#include "io/failure.h"
#include "render/renderer.h"
#include "scene/frame.h"
#include "scene/quality_control.h"

namespace tellurion::app {

/// What `--stats` tells of one frame.
struct FrameFigures {
  double time_s = 0.0;    ///< since the path began; 0 for a single picture
  double frame_ms = 0.0;  ///< update and drawing, until the picture is done
  scene::FrameStatistics scene;
  render::RenderStatistics render;
  bool complete = false;
  double quality = 1.0;     ///< in force, told by who made the frame
  double resolution = 1.0;  ///< of the picture, likewise
  int layerChanges = 0;     ///< of a layer's look since the frame before, likewise
};

/// Updates are timed by the globe, drawing here; the GPU has finished when this returns.
FrameFigures drawMeasured(render::Renderer& renderer, const render::RenderTarget& target, const scene::Frame& frame);

/// What automatic quality hears of a frame that was done at time_s.
scene::FrameCost costOf(const FrameFigures& figures, double time_s);

std::string jsonOf(const FrameFigures& figures);
std::string csvHeader();
std::string csvLine(const FrameFigures& figures);

}  // namespace tellurion::app
