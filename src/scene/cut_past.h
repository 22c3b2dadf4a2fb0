#pragma once

#include <array>

#include "scene/cut_node.h"

namespace tellurion::scene {

using TileChildren = std::array<TileFacts*, 4>;  ///< by quadrant

/// What the last frame drew, as the cut of this one asks for it: without a jump a tile parts only when it has left its
/// parent's surface, and four children become their parent only when they are back on its. Immutable.
class CutPast {
 public:
  /// Null: nothing is remembered, and nothing has to be waited for.
  explicit CutPast(const CutHistory* history) : history_(history) {}

  bool isKnown() const { return history_ != nullptr; }
  /// Fills in what the node was. `parent` is null for a root.
  void recall(CutNode& node, const CutNode* parent) const;
  /// It was drawn as a part of its parent's mesh, and what lies around it has not gone to that surface yet: its own
  /// would not look like that.
  bool staysPart(const CutNode& node) const;
  /// Of a node that was drawn as finer tiles: all of its children that were drawn look like it.
  bool isBackOnItsSurface(const CutNode& node, const TileChildren& children) const;
  /// A tile that was drawn may be split once it has left its parent's surface, and when what touches its children and
  /// is as fine as they are is on its surface there.
  bool mayPart(const CutNode& node, const TileChildren& children) const;

 private:
  const CutHistory* history_;
};

/// All corners of a tile of this level are where its parent's surface is.
bool isOnParentsSurface(const TileFacts& facts, int level, const CornerLattice& corners);

/// For the frame after this one: its leaves that are drawn, and what is over them.
void remember(const CutForest& forest, CutMemory& memory);

}  // namespace tellurion::scene
