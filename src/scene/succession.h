#pragma once

#include "scene/select.h"

namespace tellurion::scene {

/// Whether a cut may take the place of another, of the same view through other layers, without the picture getting
/// coarser anywhere: each tile that it draws is as deep as what the other draws there and as far from its parent's
/// surface as the tolerance asks, or as fine as it shall be. No split of it waits for the GPU. tolerance_px:
/// CutOptions's.
bool isAsFineAs(const Selection& next, const Selection& shown, double tolerance_px);

}  // namespace tellurion::scene
