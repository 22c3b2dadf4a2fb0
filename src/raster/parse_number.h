#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

/// Numbers in documents: a point for decimals whatever the locale.
namespace tellurion::raster {

/// Without the white space around it.
inline std::string_view trimmed(std::string_view text) {
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpace);
  return first == text.npos ? std::string_view{} : text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// The whole text, white space around it aside. Nothing: no number, not finite, or out of T's range.
template <class T>
std::optional<T> parseNumber(std::string_view text) {
  text = trimmed(text);
  if (text.empty()) return std::nullopt;
  if (text.starts_with('+')) text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

/// Numbers parted by white space or commas. Empty where one of them is none.
inline std::vector<double> parseNumbers(std::string_view text) {
  constexpr const char* kBetween = " \t\r\n,";
  std::vector<double> numbers;
  for (std::size_t at = text.find_first_not_of(kBetween); at != text.npos; at = text.find_first_not_of(kBetween, at)) {
    const std::size_t end = std::min(text.find_first_of(kBetween, at), text.size());
    const auto number = parseNumber<double>(text.substr(at, end - at));
    if (!number) return {};
    numbers.push_back(*number);
    at = end;
  }
  return numbers;
}

}  // namespace tellurion::raster
