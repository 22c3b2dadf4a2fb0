#include "scene/cut_memory.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {

void CutMemory::clear() {
  std::fill(slots_.begin(), slots_.end(), Slot{});
  used_ = 0;
}

/// Where a tile is, or would be put; there are free slots always.
std::size_t CutMemory::slotOf(const tiling::TileId& id) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = tiling::TileIdHash{}(id)&mask;
  while (slots_[i].id.level != kFree && slots_[i].id != id)
    i = (i + 1) & mask;
  return i;
}

void CutMemory::grow() {
  std::vector<Slot> old(std::max<std::size_t>(1024, 2 * slots_.size()));
  std::swap(old, slots_);
  for (const Slot& slot : old) {
    if (slot.id.level != kFree) slots_[slotOf(slot.id)] = slot;
  }
}

void CutMemory::add(const tiling::TileId& id, Was was) {
  if (2 * (used_ + 1) > slots_.size()) grow();
  Slot& slot = slots_[slotOf(id)];
  used_ += slot.id.level == kFree ? 1 : 0;
  slot = {.id = id, .was = was};
}

std::optional<CutMemory::Was> CutMemory::find(const tiling::TileId& id) const {
  if (slots_.empty()) return std::nullopt;
  const Slot& slot = slots_[slotOf(id)];
  return slot.id.level == kFree ? std::nullopt : std::optional(slot.was);
}

}  // namespace tellurion::scene
