#pragma once

#include <cstdint>

namespace tellurion::tiling {

/// Morton order: the bits of x at the even places and those of y at the odd ones, so that numbers near each other are
/// squares near each other.
std::uint64_t interleaved(std::uint32_t x, std::uint32_t y);
/// The inverse: x; y is that of `code >> 1`.
std::uint32_t evenBits(std::uint64_t code);

}  // namespace tellurion::tiling
