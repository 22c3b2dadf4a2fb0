#pragma once

#include <string>

#include "render/render_target.h"

namespace tellurion::app {

/// Writes the picture as tellurion-0001.png (the next free number) into the current folder, says so on stderr, and
/// gives the same for a notice.
std::string saveScreenshot(const render::RenderTarget& target);

}  // namespace tellurion::app
