#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace tellurion::render {

/// Hands out stretches of a line of `capacity` units: first fit, neighbours joined when given back. A value; no thread
/// rules of its own. The units may be bytes, vertices or indices.
class RangeAllocator {
 public:
  explicit RangeAllocator(std::uint32_t capacity = 0);

  std::uint32_t capacity() const { return capacity_; }
  std::uint32_t used() const { return used_; }

  /// The first unit of `count` free ones in a row; nothing when there is no such stretch. count >= 1.
  std::optional<std::uint32_t> allocate(std::uint32_t count);
  /// Exactly a stretch that allocate() gave.
  void release(std::uint32_t first, std::uint32_t count);
  /// More units at the end; what is handed out stays where it is. newCapacity >= capacity().
  void grow(std::uint32_t newCapacity);

 private:
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
  };
  void insertFree(Range range);

  std::uint32_t capacity_ = 0;
  std::uint32_t used_ = 0;
  std::vector<Range> free_;  // by first; no two touch
};

}  // namespace tellurion::render
