#pragma once

#include <string>
#include <vector>

#include "app/frame_figures.h"

namespace tellurion::app {

/// The frames of a played path as an SVG: frame time, quality, tiles wanted but missing, tiles a level, triangles and
/// GPU memory over the seconds of the path. `frames` is not empty, in order of time.
std::string benchPlot(const std::string& title, const std::string& subtitle, const std::vector<FrameFigures>& frames);

}  // namespace tellurion::app
