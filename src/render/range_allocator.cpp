#include "render/range_allocator.h"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace tellurion::render {

RangeAllocator::RangeAllocator(std::uint32_t capacity) {
  grow(capacity);
}

std::optional<std::uint32_t> RangeAllocator::allocate(std::uint32_t count) {
  assert(count > 0);
  const auto fits = std::ranges::find_if(free_, [count](const Range& r) { return r.count >= count; });
  if (fits == free_.end()) return std::nullopt;
  const std::uint32_t first = fits->first;
  fits->first += count;
  fits->count -= count;
  if (fits->count == 0) free_.erase(fits);
  used_ += count;
  return first;
}

void RangeAllocator::release(std::uint32_t first, std::uint32_t count) {
  assert(count > 0 && count <= used_ && first + count <= capacity_);
  used_ -= count;
  insertFree({first, count});
}

void RangeAllocator::grow(std::uint32_t newCapacity) {
  assert(newCapacity >= capacity_);
  if (newCapacity == capacity_) return;
  insertFree({capacity_, newCapacity - capacity_});
  capacity_ = newCapacity;
}

void RangeAllocator::insertFree(Range range) {
  const auto next = std::ranges::lower_bound(free_, range.first, {}, [](const Range& r) { return r.first; });
  const bool joinsNext = next != free_.end() && range.first + range.count == next->first;
  const bool joinsPrevious = next != free_.begin() && std::prev(next)->first + std::prev(next)->count == range.first;
  if (joinsPrevious) {
    const auto previous = std::prev(next);
    previous->count += range.count + (joinsNext ? next->count : 0);
    if (joinsNext) free_.erase(next);
  } else if (joinsNext) {
    next->first = range.first;
    next->count += range.count;
  } else {
    free_.insert(next, range);
  }
}

}  // namespace tellurion::render
