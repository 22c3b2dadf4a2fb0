#include "scene/corner_lattice.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace tellurion::scene {

TileCorners tileCorners(const tiling::Tiling& tiling, const tiling::TileId& id) {
  const auto key = [&](double s, double t) {
    const geo::Vec3 n = tiling.direction(tiling::rootPointIn(id, s, t)).n;
    std::uint64_t hash = 0x243f6a8885a308d3u;
    for (const double v : {n.x, n.y, n.z}) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(v + 0.0)) * 0x9e3779b97f4a7c15u;  // + 0.0: one zero only
      hash ^= hash >> 32;
    }
    return std::max(hash, CornerKey{1});
  };
  return {.corners = {key(0.0, 0.0), key(1.0, 0.0), key(0.0, 1.0), key(1.0, 1.0)},
          .edgeMiddles = {key(0.5, 0.0), key(1.0, 0.5), key(0.5, 1.0), key(0.0, 0.5)}};
}

CornerLattice::Corner& CornerLattice::at(CornerKey key) {
  if (2 * (used_ + 1) > slots_.size()) grow();
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = key & mask;
  while (slots_[i].key != kFreeSlot && slots_[i].key != key)
    i = (i + 1) & mask;
  if (slots_[i].key == kFreeSlot) {
    slots_[i].key = key;
    ++used_;
  }
  return slots_[i];
}

const CornerLattice::Corner* CornerLattice::find(CornerKey key) const {
  if (slots_.empty()) return nullptr;
  const std::size_t mask = slots_.size() - 1;
  for (std::size_t i = key & mask; slots_[i].key != kFreeSlot; i = (i + 1) & mask) {
    if (slots_[i].key == key) return &slots_[i];
  }
  return nullptr;
}

void CornerLattice::grow() {
  std::vector<Corner> old(std::max<std::size_t>(1024, 2 * slots_.size()));
  std::swap(old, slots_);
  const std::size_t mask = slots_.size() - 1;
  for (const Corner& corner : old) {
    if (corner.key == kFreeSlot) continue;
    std::size_t i = corner.key & mask;
    while (slots_[i].key != kFreeSlot)
      i = (i + 1) & mask;
    slots_[i] = corner;
  }
}

void CornerLattice::clear() {
  std::fill(slots_.begin(), slots_.end(), Corner{});
  used_ = 0;
}

void CornerLattice::add(const TileCorners& tile, int level, bool drawn, bool fromParent, float goal, float speed) {
  for (const CornerKey key : tile.corners) {
    Corner& c = at(key);
    if (level > c.finest) {
      c.finest = static_cast<std::int8_t>(level);
      c.goal = 0.0f;
    }
    if (!drawn) continue;
    c.fromParent = c.fromParent || fromParent;
    c.speed = std::max(c.speed, speed);
    c.coarsestDrawn = std::min(c.coarsestDrawn, static_cast<std::int8_t>(level));
    if (level == c.finest) c.goal = std::max(c.goal, goal);
  }
  for (const CornerKey key : tile.edgeMiddles) {
    if (!drawn) continue;
    Corner& c = at(key);
    c.coarsestDrawn = std::min(c.coarsestDrawn, static_cast<std::int8_t>(level));
    c.finest = std::max(c.finest, static_cast<std::int8_t>(level));
  }
}

bool CornerLattice::settle(const CornerLattice* last, float step) {
  bool atGoals = true;
  for (Corner& c : slots_) {
    if (c.key == kFreeSlot) continue;
    const float goal = c.coarsestDrawn < c.finest ? 0.0f : c.goal;
    c.value = goal;
    const Corner* before = last != nullptr ? last->find(c.key) : nullptr;
    if (before == nullptr && !c.fromParent) continue;
    const float from = before != nullptr ? valueIn(*before, c.finest) : 0.0f;
    c.value = std::clamp(goal, from - step * c.speed, from + step * c.speed);
    atGoals = atGoals && c.value == goal;
  }
  return atGoals;
}

float CornerLattice::valueIn(const Corner& corner, int level) {
  if (level < corner.finest) return 1.0f;
  return level == corner.finest ? corner.value : 0.0f;
}

float CornerLattice::valueAt(CornerKey corner, int level) const {
  const Corner* found = find(corner);
  return found == nullptr ? 0.0f : valueIn(*found, level);
}

}  // namespace tellurion::scene
