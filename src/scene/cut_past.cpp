#include "scene/cut_past.h"

#include <algorithm>

namespace tellurion::scene {

bool isOnParentsSurface(const TileFacts& facts, int level, const CornerLattice& corners) {
  return std::all_of(facts.corners.corners.begin(), facts.corners.corners.end(),
                     [&](CornerKey corner) { return !(corners.valueAt(corner, level) > 0.0f); });
}

Before CutPast::of(const tiling::TileId& id, const CutNode* parent) const {
  if (history_ == nullptr) return Before::nowhere;
  if (const auto was = history_->last->find(id)) return *was == CutMemory::Was::leaf ? Before::here : Before::below;
  if (parent == nullptr) return Before::nowhere;
  return parent->before == Before::here || parent->before == Before::above ? Before::above : Before::nowhere;
}

bool CutPast::isBackOnItsSurface(const CutNode& node, const TileChildren& children) const {
  for (int q = 0; q < 4; ++q) {
    const tiling::TileId child = node.id.child(q);
    const auto was = history_->last->find(child);
    if (!was) continue;
    if (*was == CutMemory::Was::split) return false;
    if (!isOnParentsSurface(*children[static_cast<std::size_t>(q)], child.level, history_->last->corners)) return false;
  }
  return true;
}

bool CutPast::mayPart(const CutNode& node, const TileChildren& children) const {
  if (history_ == nullptr || node.before == Before::below || node.before == Before::nowhere) return true;
  if (node.before == Before::above) return false;
  const CornerLattice& last = history_->last->corners;
  return std::all_of(node.facts->corners.corners.begin(), node.facts->corners.corners.end(),
                     [&](CornerKey corner) { return last.valueAt(corner, node.id.level) >= 1.0f; }) &&
         std::all_of(children.begin(), children.end(),
                     [&](const TileFacts* child) { return isOnParentsSurface(*child, node.id.level + 1, last); });
}

void remember(CutForest& forest, CutMemory& memory) {
  memory.clear();
  // Children follow their parents.
  for (auto node = forest.nodes.rbegin(); node != forest.nodes.rend(); ++node) {
    const bool drawn = node->isDrawn();
    if (!drawn && !node->hasDrawn) continue;
    if (node->parent >= 0) forest.at(node->parent).hasDrawn = true;
    memory.add(node->id, drawn ? CutMemory::Was::leaf : CutMemory::Was::split);
  }
}

}  // namespace tellurion::scene
