#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "io/failure.h"

namespace tellurion::scene {

/// A value of a scene file: plain data, whatever the file's format.
struct Entry {
  enum class Shape { value, list, table };
  std::string key;  ///< of an entry of a list: the list's
  Shape shape = Shape::value;
  std::variant<std::monostate, bool, std::int64_t, double, std::string> value;  ///< monostate: a time, or no value
  std::vector<Entry> parts;                                                     ///< of a list or a table
  std::optional<std::string> written;  ///< as a setting of the command line has it: 101820 may be a colour
  std::string where;                   ///< for messages
  std::string keyWhere;                ///< likewise

  bool isText() const { return std::holds_alternative<std::string>(value); }
};

/// What those who read a scene's entries throw, and nobody else: it leaves parseScene as a value.
struct EntryFault {
  io::Failure failure;
};

[[noreturn]] void complain(const std::string& where, std::string message,
                           io::Failure::Code code = io::Failure::Code::invalidArgument);

using Keys = std::vector<std::string_view>;

/// Of a table; null: it does not have it.
const Entry* find(const Entry& table, std::string_view key);
/// Complains of any other key of the table.
void allow(const Entry& table, const Keys& keys);
/// Each complains where the entry is something else, or out of range. low, high: inclusive.
const Entry& asTable(const Entry& entry);
std::string asText(const Entry& entry);
/// Nothing: it is none.
std::optional<double> numberOf(const Entry& entry);
double asNumber(const Entry& entry, double low, double high);
int asWhole(const Entry& entry, int low, int high);
bool asBoolean(const Entry& entry);
/// Seconds since 1970-01-01T00:00:00Z of a text.
double asTime_s(const Entry& entry);
/// "RRGGBB", with or without a "#" before it.
std::array<std::uint8_t, 3> asColour(const Entry& entry);

/// Of tables: what the key says, or else what stands for it.
std::optional<std::string> textAt(const Entry& table, std::string_view key);
double numberAt(const Entry& table, std::string_view key, double low, double high, double otherwise);
bool booleanAt(const Entry& table, std::string_view key, bool otherwise);
/// Each [[key]]; none where the key is left out.
std::vector<const Entry*> tablesAt(const Entry& table, std::string_view key);

}  // namespace tellurion::scene
