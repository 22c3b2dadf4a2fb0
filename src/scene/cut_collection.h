#pragma once

#include <vector>

#include "scene/cut_node.h"

namespace tellurion::scene {

struct DrawnLeaf {
  int node = 0;
  int drawn = -1;                  ///< which of Selection::drawn, -1: none
  std::uint8_t coarseEdges = 0;    ///< as SelectedTile has it
  bool isMorphed = false;          ///< by the values at its corners; else it is its own
  CornerLattice::Places places{};  ///< of its corners
};

/// What a cut is collected in: its memory is kept from frame to frame.
struct CollectionBuffers {
  std::vector<DrawnLeaf> leaves;
  CornerLattice corners;  ///< where nothing is remembered
};

/// Fills in what `out` draws of a grown forest: its leaves that are seen, how far each has left its parent's surface,
/// and how far off it is; and remembers it in the history, where there is one.
void collectCut(const CutOptions& options, const CutHistory* history, double pixelAngle, CutForest& forest,
                CollectionBuffers& buffers, Selection& out);

/// The morph values of what is drawn, as they have gone on since.
void moveOn(const CornerLattice& corners, const CollectionBuffers& buffers, Selection& out);

}  // namespace tellurion::scene
