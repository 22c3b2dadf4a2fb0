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
    // Eight at a time, from a table for each of their distances to the end: a chain of look-ups for each byte costs
    // more than a tile's compression leaves room for.
    std::size_t i = 0;
    for (; i + kSlices <= bytes.size(); i += kSlices) {
      std::uint32_t next = 0;
      for (std::size_t k = 0; k < kSlices; ++k) {
        const std::uint32_t before = k < 4 ? (state_ >> (8 * k)) & 0xffu : 0u;
        next ^= kTables[kSlices - 1 - k][before ^ std::to_integer<std::uint32_t>(bytes[i + k])];
      }
      state_ = next;
    }
    for (; i < bytes.size(); ++i)
      state_ = kTables[0][(state_ ^ std::to_integer<std::uint32_t>(bytes[i])) & 0xffu] ^ (state_ >> 8u);
  }
  std::uint32_t value() const { return ~state_; }

 private:
  static constexpr std::size_t kSlices = 8;
  using Table = std::array<std::uint32_t, 256>;

  /// The change of each byte, lowest bit first; in table k when k zero bytes follow it.
  static constexpr std::array<Table, kSlices> kTables = [] {
    std::array<Table, kSlices> tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int bit = 0; bit < 8; ++bit)
        c = (c & 1u) != 0 ? 0xedb88320u ^ (c >> 1u) : c >> 1u;
      tables[0][i] = c;
    }
    for (std::size_t k = 1; k < kSlices; ++k) {
      for (std::size_t i = 0; i < 256; ++i) {
        const std::uint32_t c = tables[k - 1][i];
        tables[k][i] = tables[0][c & 0xffu] ^ (c >> 8u);
      }
    }
    return tables;
  }();
  std::uint32_t state_ = 0xffffffffu;
};

}  // namespace tellurion::io
