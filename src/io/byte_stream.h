#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

namespace tellurion::io {

/// Puts values one after the other, little-endian. A value.
class ByteWriter {
 public:
  template <class T>
  requires std::is_unsigned_v<T>
  void add(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_.push_back(static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xffu));
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void addBool(bool value) { add(static_cast<std::uint8_t>(value)); }
  void addBytes(std::string_view bytes) { bytes_.append(bytes); }

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads what ByteWriter wrote; safe on any bytes. What is asked for beyond the end is zero, and isGood() false from
/// then on. The bytes must outlive it.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_unsigned_v<T> T take() {
    const std::string_view from = takeBytes(sizeof(T));
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < from.size(); ++i)
      value |= std::uint64_t{static_cast<unsigned char>(from[i])} << (8 * i);
    return static_cast<T>(value);
  }
  double takeDouble() { return std::bit_cast<double>(take<std::uint64_t>()); }
  /// Bytes other than 0 and 1 are not good.
  bool takeBool() {
    const auto value = take<std::uint8_t>();
    isGood_ = isGood_ && value <= 1;
    return value == 1;
  }
  /// Exactly so many, or none.
  std::string_view takeBytes(std::size_t count) {
    isGood_ = isGood_ && count <= bytes_.size();
    if (!isGood_) return {};
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  std::string_view rest() const { return bytes_; }

  bool isGood() const { return isGood_; }
  bool isAtEnd() const { return isGood_ && bytes_.empty(); }

 private:
  std::string_view bytes_;
  bool isGood_ = true;
};

}  // namespace tellurion::io
