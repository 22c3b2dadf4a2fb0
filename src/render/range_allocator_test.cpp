#include "render/range_allocator.h"

#include <gtest/gtest.h>

#include <map>

#include "geo/seed_test.h"

namespace tellurion::render {
namespace {

TEST(RangeAllocator, EmptyOneGivesNothing) {
  RangeAllocator ranges;
  EXPECT_EQ(ranges.allocate(1), std::nullopt);
  EXPECT_EQ(ranges.capacity(), 0u);
}

TEST(RangeAllocator, GivesAllItHasAndNoMore) {
  RangeAllocator ranges(10);
  EXPECT_EQ(ranges.allocate(10), 0u);
  EXPECT_EQ(ranges.used(), 10u);
  EXPECT_EQ(ranges.allocate(1), std::nullopt);
  ranges.release(0, 10);
  EXPECT_EQ(ranges.used(), 0u);
  EXPECT_EQ(ranges.allocate(11), std::nullopt);
}

TEST(RangeAllocator, JoinsNeighboursInAnyOrderOfRelease) {
  const std::array<std::array<std::uint32_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (const auto& order : orders) {
    RangeAllocator ranges(9);
    for (std::uint32_t i = 0; i < 3; ++i)
      ASSERT_EQ(ranges.allocate(3), 3 * i);
    for (const std::uint32_t i : order)
      ranges.release(3 * i, 3);
    EXPECT_EQ(ranges.allocate(9), 0u);
  }
}

TEST(RangeAllocator, GrowingJoinsTheFreeEnd) {
  RangeAllocator ranges(8);
  ASSERT_EQ(ranges.allocate(5), 0u);
  ranges.grow(12);
  EXPECT_EQ(ranges.allocate(7), 5u);
  ranges.grow(12);
  EXPECT_EQ(ranges.allocate(1), std::nullopt);
}

// Against the plainest book-keeping: a map of what is handed out.
TEST(RangeAllocator, NothingOverlapsAndNothingIsLost) {
  auto random = geo::seededGenerator();
  constexpr std::uint32_t kUnits = 1000;
  RangeAllocator ranges(kUnits);
  std::map<std::uint32_t, std::uint32_t> held;
  std::uint32_t used = 0;
  const auto largestGap = [&] {
    std::uint32_t gap = 0;
    std::uint32_t end = 0;
    for (const auto& [first, count] : held) {
      gap = std::max(gap, first - end);
      end = first + count;
    }
    return std::max(gap, kUnits - end);
  };
  for (int step = 0; step < 5000; ++step) {
    if (held.empty() || random() % 3 != 0) {
      const auto count = static_cast<std::uint32_t>(random() % 40 + 1);
      const auto first = ranges.allocate(count);
      ASSERT_EQ(first.has_value(), count <= largestGap());
      if (!first) continue;
      const auto next = held.lower_bound(*first);
      ASSERT_TRUE(next == held.end() || *first + count <= next->first);
      ASSERT_TRUE(next == held.begin() || std::prev(next)->first + std::prev(next)->second <= *first);
      held[*first] = count;
      used += count;
    } else {
      const auto victim = std::next(held.begin(), static_cast<std::ptrdiff_t>(random() % held.size()));
      ranges.release(victim->first, victim->second);
      used -= victim->second;
      held.erase(victim);
    }
    ASSERT_EQ(ranges.used(), used);
  }
  for (const auto& [first, count] : held)
    ranges.release(first, count);
  EXPECT_EQ(ranges.allocate(kUnits), 0u);
}

}  // namespace
}  // namespace tellurion::render
