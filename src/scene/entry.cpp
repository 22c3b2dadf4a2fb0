#include "scene/entry.h"

#include <fmt/format.h>

#include <algorithm>

#include "raster/time_extent.h"

namespace tellurion::scene {

void complain(const std::string& where, std::string message, io::Failure::Code code) {
  throw EntryFault{{.code = code, .message = std::move(message), .where = where}};
}

const Entry* find(const Entry& table, std::string_view key) {
  const auto found = std::ranges::find(table.parts, key, &Entry::key);
  return found != table.parts.end() ? &*found : nullptr;
}

void allow(const Entry& table, const Keys& keys) {
  for (const Entry& entry : table.parts) {
    if (std::ranges::find(keys, entry.key) == keys.end())
      complain(entry.keyWhere, fmt::format("unknown key '{}'; allowed here: {}", entry.key, fmt::join(keys, ", ")));
  }
}

const Entry& asTable(const Entry& entry) {
  if (entry.shape != Entry::Shape::table) complain(entry.where, fmt::format("'{}' must be a table", entry.key));
  return entry;
}

std::string asText(const Entry& entry) {
  if (const auto* text = std::get_if<std::string>(&entry.value)) return *text;
  if (!entry.written) complain(entry.where, fmt::format("'{}' must be a text in quotes", entry.key));
  return *entry.written;
}

std::optional<double> numberOf(const Entry& entry) {
  if (const auto* whole = std::get_if<std::int64_t>(&entry.value)) return static_cast<double>(*whole);
  const auto* real = std::get_if<double>(&entry.value);
  return real != nullptr ? std::optional(*real) : std::nullopt;
}

double asNumber(const Entry& entry, double low, double high) {
  const auto value = numberOf(entry);
  if (!value || !(*value >= low && *value <= high))
    complain(entry.where, fmt::format("'{}' must be a number from {} to {}", entry.key, low, high));
  return *value;
}

int asWhole(const Entry& entry, int low, int high) {
  const auto* value = std::get_if<std::int64_t>(&entry.value);
  if (value == nullptr || *value < low || *value > high)
    complain(entry.where, fmt::format("'{}' must be a whole number from {} to {}", entry.key, low, high));
  return static_cast<int>(*value);
}

bool asBoolean(const Entry& entry) {
  const auto* value = std::get_if<bool>(&entry.value);
  if (value == nullptr) complain(entry.where, fmt::format("'{}' must be true or false", entry.key));
  return *value;
}

double asTime_s(const Entry& entry) {
  const auto seconds = raster::secondsOfTime(asText(entry));
  if (!seconds) complain(entry.where, fmt::format("'{}' must be a time like \"2004-01-31T12:00:00Z\"", entry.key));
  return *seconds;
}

std::array<std::uint8_t, 3> asColour(const Entry& entry) {
  std::string text = asText(entry);
  if (text.starts_with('#')) text.erase(0, 1);
  const bool isHex = text.size() == 6 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
  if (!isHex) complain(entry.where, fmt::format("'{}' must be a colour \"RRGGBB\" in hexadecimal digits", entry.key));
  std::array<std::uint8_t, 3> out{};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = static_cast<std::uint8_t>(std::stoul(text.substr(2 * i, 2), nullptr, 16));
  return out;
}

std::optional<std::string> textAt(const Entry& table, std::string_view key) {
  const Entry* entry = find(table, key);
  return entry != nullptr ? std::optional(asText(*entry)) : std::nullopt;
}

double numberAt(const Entry& table, std::string_view key, double low, double high, double otherwise) {
  const Entry* entry = find(table, key);
  return entry != nullptr ? asNumber(*entry, low, high) : otherwise;
}

bool booleanAt(const Entry& table, std::string_view key, bool otherwise) {
  const Entry* entry = find(table, key);
  return entry != nullptr ? asBoolean(*entry) : otherwise;
}

std::vector<const Entry*> tablesAt(const Entry& table, std::string_view key) {
  std::vector<const Entry*> out;
  const Entry* list = find(table, key);
  if (list == nullptr) return out;
  if (list->shape != Entry::Shape::list)
    complain(list->where, fmt::format("layers are written as [[{}]], one for each", key));
  for (const Entry& each : list->parts)
    out.push_back(&asTable(each));
  return out;
}

}  // namespace tellurion::scene
