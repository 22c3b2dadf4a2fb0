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

/// What the leaves of a cut come to, as far as they are seen.
struct LeafTally {
  int leaves = 0;
  std::int64_t triangles = 0;
  std::int64_t bytes = 0;
  std::uint64_t copies_bytes = 0;  ///< that drawing them would take
};

/// What a cut grows in: its memory is kept from frame to frame.
struct GrowthBuffers {
  CutForest forest;
  std::vector<WaitingNode> queue;   ///< a heap
  std::vector<WaitingNode> costly;  ///< what would copy to the GPU
  LeafTally tally;
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
/// wanted (unsorted), the counts, what is capped or held back, and what drawing its leaves leaves of the copies.
void growCut(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out);

/// The same a part at a time, of a cut without a past: first its roots, then nodes that ask for a split, so many at
/// most. Tells how many it were; fewer than asked for: it is grown. Between two parts the facts of its nodes must stay
/// where they are.
void growRoots(const GrowthRules& rules, GrowthBuffers& buffers, Selection& out);
std::size_t growOn(const GrowthRules& rules, std::size_t most, GrowthBuffers& buffers, Selection& out);

/// Each tile once, as urgent as the most urgent of those who asked for it; the most urgent first.
void sortWanted(std::vector<WantedTile>& wanted);

}  // namespace tellurion::scene
