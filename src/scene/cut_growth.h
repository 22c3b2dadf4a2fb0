#pragma once

#include <vector>

#include "scene/cut_past.h"
#include "scene/cut_sight.h"

namespace tellurion::scene {

/// A node that asks for a split.
struct WaitingNode {
  double need = 0.0;
  tiling::TileId id;  ///< breaks ties, so that the order is the same on every run
  int node = 0;
  bool kept = false;  ///< as CutNode has it: it is there for what it was in the last frame alone
  bool operator<(const WaitingNode& o) const { return need != o.need ? need < o.need : id > o.id; }
};

/// What a cut grows in: its memory is kept from frame to frame.
struct GrowthBuffers {
  CutForest forest;
  std::vector<WaitingNode> queue;   ///< a heap
  std::vector<WaitingNode> costly;  ///< what would copy to the GPU
};

/// What a cut is grown by.
struct GrowthRules {
  const tiling::Tiling& tiling;
  const CutOptions& options;
  const CutSight& sight;
  const CutPast& past;
  TileTree& tree;
};

/// Grows the forest from the roots, worst first, as far as select() says, and fills in what `out` tells of it: what is
/// wanted, the counts, what is capped or held back, and what drawing its leaves leaves of the copies.
void growCut(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out);

}  // namespace tellurion::scene
