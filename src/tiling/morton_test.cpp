#include "tiling/morton.h"

#include <gtest/gtest.h>

#include "geo/seed_test.h"

namespace tellurion::tiling {
namespace {

/// Bit by bit, as it is defined.
std::uint64_t slowlyInterleaved(std::uint32_t x, std::uint32_t y) {
  std::uint64_t code = 0;
  for (unsigned bit = 0; bit < 32; ++bit) {
    code |= std::uint64_t{(x >> bit) & 1u} << (2 * bit);
    code |= std::uint64_t{(y >> bit) & 1u} << (2 * bit + 1);
  }
  return code;
}

void expectThereAndBack(std::uint32_t x, std::uint32_t y) {
  const std::uint64_t code = interleaved(x, y);
  ASSERT_EQ(code, slowlyInterleaved(x, y));
  ASSERT_EQ(evenBits(code), x);
  ASSERT_EQ(evenBits(code >> 1u), y);
}

TEST(Morton, EveryBitGoesThereAndBack) {
  expectThereAndBack(0, 0);
  expectThereAndBack(~0u, ~0u);
  for (unsigned bit = 0; bit < 32; ++bit) {
    expectThereAndBack(1u << bit, 0);
    expectThereAndBack(0, 1u << bit);
  }
  auto random = geo::seededGenerator();
  for (int i = 0; i < 100000; ++i)
    expectThereAndBack(static_cast<std::uint32_t>(random()), static_cast<std::uint32_t>(random()));
}

}  // namespace
}  // namespace tellurion::tiling
