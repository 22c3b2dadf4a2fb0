#pragma once

#include "scene/globe.h"

namespace tellurion::app {

struct LayersDrawn {
  bool changed = false;    ///< the picture must be drawn again
  bool wantsMore = false;  ///< the hand asks for further layers
};

/// The imagery layers from the top one down, with what can be changed of each, and arrows that change their order.
/// Between ViewWindow::beginPanels() and endPanels().
LayersDrawn drawLayers(scene::Globe& globe);

}  // namespace tellurion::app
