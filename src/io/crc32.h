#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tellurion::io {

/// CRC-32 of ISO 3309 (ITU-T V.42, 8.1.1.6.2), as PNG and zip have it: of bytes added one after the other.
class Crc32 {
 public:
  void add(std::span<const std::byte> bytes) {
    for (const std::byte b : bytes) {
      state_ = kTable[(state_ ^ std::to_integer<std::uint32_t>(b)) & 0xffu] ^ (state_ >> 8u);
    }
  }
  std::uint32_t value() const { return ~state_; }

 private:
  /// The change of each byte, lowest bit first.
  static constexpr std::array<std::uint32_t, 256> kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit)
        c = (c & 1u) != 0 ? 0xedb88320u ^ (c >> 1u) : c >> 1u;
      table[i] = c;
    }
    return table;
  }();
  std::uint32_t state_ = 0xffffffffu;
};

}  // namespace tellurion::io
