#pragma once

#include "scene/cut_node.h"

namespace tellurion::scene {

/// Fills in what `out` draws of a grown forest: its leaves that are seen, how far each has left its parent's surface,
/// and how far off it is; and remembers it in the history, where there is one. ownCorners: memory to work in where
/// there is none.
void collectCut(const CutOptions& options, const CutHistory* history, double pixelAngle, CutForest& forest,
                CornerLattice& ownCorners, Selection& out);

}  // namespace tellurion::scene
