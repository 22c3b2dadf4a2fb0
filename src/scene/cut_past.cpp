#include "scene/cut_past.h"

#include <algorithm>

namespace tellurion::scene {

bool isOnParentsSurface(const TileFacts& facts, int level, const CornerLattice& corners) {
  return std::all_of(facts.corners.begin(), facts.corners.end(),
                     [&](CornerKey corner) { return !(corners.valueAt(corner, level) > 0.0f); });
}

namespace {

/// The same, but for corners that it shares with tiles finer than itself: there it is its own at once, whatever it
/// takes the place of.
bool mayBeginOnParentsSurface(const TileFacts& facts, int level, const CornerLattice& corners) {
  return std::all_of(facts.corners.begin(), facts.corners.end(), [&](CornerKey corner) {
    return !(corners.valueAt(corner, level) > 0.0f) || corners.hasFiner(corner, level);
  });
}

}  // namespace

void CutPast::recall(CutNode& node, const CutNode* parent) const {
  if (history_ == nullptr) return;
  const CutMemory& last = *history_->last;
  node.past = parent == nullptr ? last.rootPlace(node.id.root) : last.childPlace(parent->past, node.id.quadrant());
  switch (last.at(node.past)) {
    case CutMemory::Was::leaf:
      node.before = Before::here;
      break;
    case CutMemory::Was::part:
      node.before = Before::above;
      break;
    case CutMemory::Was::split:
      node.before = Before::below;
      break;
    case CutMemory::Was::nowhere:
      if (parent != nullptr && (parent->before == Before::here || parent->before == Before::above))
        node.before = Before::above;
      break;
  }
}

bool CutPast::staysPart(const CutNode& node) const {
  return history_ != nullptr && history_->last->at(node.past) == CutMemory::Was::part &&
         !mayBeginOnParentsSurface(*node.facts, node.id.level, history_->last->corners);
}

bool CutPast::isBackOnItsSurface(const CutNode& node, const TileChildren& children) const {
  const CutMemory& last = *history_->last;
  for (int q = 0; q < 4; ++q) {
    const CutMemory::Was was = last.at(last.childPlace(node.past, q));
    if (was == CutMemory::Was::nowhere || was == CutMemory::Was::part) continue;
    if (was == CutMemory::Was::split) return false;
    if (!isOnParentsSurface(*children[static_cast<std::size_t>(q)], node.id.level + 1, last.corners)) return false;
  }
  return true;
}

bool CutPast::mayPart(const CutNode& node, const TileChildren& children) const {
  if (history_ == nullptr || node.before == Before::below || node.before == Before::nowhere) return true;
  if (node.before == Before::above) return false;
  const CornerLattice& last = history_->last->corners;
  return std::all_of(node.facts->corners.begin(), node.facts->corners.end(),
                     [&](CornerKey corner) { return last.valueAt(corner, node.id.level) >= 1.0f; }) &&
         std::all_of(children.begin(), children.end(),
                     [&](const TileFacts* child) { return mayBeginOnParentsSurface(*child, node.id.level + 1, last); });
}

void remember(const CutForest& forest, CutMemory& memory) {
  memory.start(forest.nodes.size());
  // Children follow their parents.
  for (int i = static_cast<int>(forest.nodes.size()) - 1; i >= 0; --i) {
    const CutNode& node = forest.at(i);
    if (node.firstChild < 0) {
      if (node.isDrawn()) memory.set(i, node.part ? CutMemory::Was::part : CutMemory::Was::leaf, -1);
      continue;
    }
    bool hasDrawn = false;
    for (int q = 0; q < 4; ++q)
      hasDrawn = hasDrawn || memory.at(node.firstChild + q) != CutMemory::Was::nowhere;
    if (hasDrawn) memory.set(i, CutMemory::Was::split, node.firstChild);
  }
}

}  // namespace tellurion::scene
