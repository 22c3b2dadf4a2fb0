#pragma once

#include <cstdint>

namespace tellurion::tiling {

/// The bits of x at the even places.
inline std::uint64_t spreadBits(std::uint32_t bits) {
  std::uint64_t x = bits;
  x = (x | (x << 16u)) & 0x0000FFFF0000FFFFu;
  x = (x | (x << 8u)) & 0x00FF00FF00FF00FFu;
  x = (x | (x << 4u)) & 0x0F0F0F0F0F0F0F0Fu;
  x = (x | (x << 2u)) & 0x3333333333333333u;
  return (x | (x << 1u)) & 0x5555555555555555u;
}

/// Morton order: the bits of x at the even places and those of y at the odd ones, so that numbers near each other are
/// squares near each other.
inline std::uint64_t interleaved(std::uint32_t x, std::uint32_t y) {
  return spreadBits(x) | (spreadBits(y) << 1u);
}

/// The inverse: x; y is that of `code >> 1`.
inline std::uint32_t evenBits(std::uint64_t code) {
  code &= 0x5555555555555555u;
  code = (code | (code >> 1u)) & 0x3333333333333333u;
  code = (code | (code >> 2u)) & 0x0F0F0F0F0F0F0F0Fu;
  code = (code | (code >> 4u)) & 0x00FF00FF00FF00FFu;
  code = (code | (code >> 8u)) & 0x0000FFFF0000FFFFu;
  return static_cast<std::uint32_t>(code | (code >> 16u));
}

}  // namespace tellurion::tiling
