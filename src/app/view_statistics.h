#pragma once

#include <vector>

#include "app/frame_figures.h"
#include "app/view_panels.h"

namespace tellurion::app {

/// What the window's statistics tell of a frame, a line each.
std::vector<Figure> statisticsLines(const FrameFigures& figures, bool automaticQuality);

}  // namespace tellurion::app
