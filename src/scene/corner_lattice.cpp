#include "scene/corner_lattice.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr float kAboveRounding = 1.001f;

}  // namespace

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
  return {key(0.0, 0.0), key(1.0, 0.0), key(0.0, 1.0), key(1.0, 1.0)};
}

/// Where a corner is listed, or would be; there are free slots always.
std::size_t CornerLattice::slotOf(CornerKey key) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = key & mask;
  while (slots_[i] != kFreeSlot && corners_[slots_[i]].key != key)
    i = (i + 1) & mask;
  return i;
}

void CornerLattice::grow() {
  slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kFreeSlot);
  for (std::uint32_t place = 0; place < corners_.size(); ++place)
    slots_[slotOf(corners_[place].key)] = place;
}

std::uint32_t CornerLattice::placeOf(CornerKey key) {
  if (2 * (corners_.size() + 1) > slots_.size()) grow();
  std::uint32_t& slot = slots_[slotOf(key)];
  if (slot == kFreeSlot) {
    slot = static_cast<std::uint32_t>(corners_.size());
    corners_.push_back({.key = key});
  }
  return slot;
}

void CornerLattice::clear() {
  gone_ = 0.0f;
  corners_.clear();
  std::fill(slots_.begin(), slots_.end(), kFreeSlot);
}

void CornerLattice::add(const TileCorners& tile, const Leaf& leaf, Places* told) {
  const auto level = static_cast<std::int8_t>(leaf.id.level);
  Places places{};
  for (std::size_t q = 0; q < tile.size(); ++q) {
    places[q] = placeOf(tile[q]);
    Corner& c = corners_[places[q]];
    if (level > c.finest) {
      c.finest = level;
      c.goal = 0.0f;
    }
    if (!leaf.drawn) continue;
    if (leaf.isPart) {
      c.coarsestDrawn = std::min(c.coarsestDrawn, static_cast<std::int8_t>(level - 1));
      continue;
    }
    c.fromParent = c.fromParent || leaf.fromParent;
    c.speed = std::max(c.speed, leaf.speed);
    c.coarsestDrawn = std::min(c.coarsestDrawn, level);
    if (level == c.finest) c.goal = std::max(c.goal, leaf.goal);
  }
  if (leaf.coarseEdges != 0) meetCoarser(places, leaf);
  if (told != nullptr) *told = places;
}

/// A tile that is coarser across an edge has the middle of its own edge where this tile has the corner that is not its
/// parent's as well.
void CornerLattice::meetCoarser(const Places& places, const Leaf& leaf) {
  // By tiling::Edge, the quadrants at its ends.
  constexpr std::array<std::array<int, 2>, 4> kEnds{{{0, 1}, {1, 3}, {2, 3}, {0, 2}}};
  for (std::size_t edge = 0; edge < kEnds.size(); ++edge) {
    if (((leaf.coarseEdges >> edge) & 1) == 0) continue;
    const int middle = kEnds[edge][0] == leaf.id.quadrant() ? kEnds[edge][1] : kEnds[edge][0];
    Corner& c = corners_[places[static_cast<std::size_t>(middle)]];
    c.coarsestDrawn = std::min(c.coarsestDrawn, static_cast<std::int8_t>(leaf.id.level - 1));
  }
}

float CornerLattice::settle(const CornerLattice* last, float step) {
  float left = 0.0f;
  for (Corner& c : corners_) {
    // What is coarser still cannot take the place of the finest: it is joined to them as they are.
    if (c.coarsestDrawn + 1 == c.finest) c.goal = 0.0f;
    c.value = c.goal;
    const Corner* before = last != nullptr ? last->find(c.key) : nullptr;
    if (before == nullptr && !c.fromParent) continue;
    const float from = before != nullptr ? last->valueIn(*before, c.finest) : 0.0f;
    c.value = std::clamp(c.goal, from - step * c.speed, from + step * c.speed);
    left = std::max(left, kAboveRounding * std::abs(c.goal - c.value) / c.speed);
  }
  return left;
}

const CornerLattice::Corner* CornerLattice::find(CornerKey key) const {
  if (corners_.empty()) return nullptr;
  const std::uint32_t place = slots_[slotOf(key)];
  return place == kFreeSlot ? nullptr : &corners_[place];
}

bool CornerLattice::hasFiner(CornerKey corner, int level) const {
  const Corner* found = find(corner);
  return found != nullptr && level < found->finest;
}

float CornerLattice::valueAt(CornerKey corner, int level) const {
  const Corner* found = find(corner);
  return found == nullptr ? 0.0f : valueIn(*found, level);
}

}  // namespace tellurion::scene
