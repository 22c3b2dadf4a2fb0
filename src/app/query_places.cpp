#include "app/query_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

#include "raster/parse_number.h"

namespace tellurion::app {
namespace {

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

/// A number that a blank, a comma or the end follows; these stay.
std::optional<double> takeNumber(std::string_view& text) {
  text = raster::trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (!text.empty() && !isBlank(text.front()) && text.front() != ',') return std::nullopt;
  return value;
}

std::optional<double> wholeNumber(std::string_view text) {
  const auto number = takeNumber(text);
  return number && raster::trimmed(text).empty() ? number : std::nullopt;
}

std::optional<LatLon> checked(double lat, double lon) {
  if (!(std::abs(lat) <= 90.0) || !(std::abs(lon) <= 720.0)) return std::nullopt;
  return LatLon{lat, lon};
}

/// Between commas that are not quoted; quotes around a field are gone.
std::vector<std::string_view> fieldsOf(std::string_view line) {
  std::vector<std::string_view> fields;
  bool isQuoted = false;
  std::size_t start = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') isQuoted = !isQuoted;
    if (i < line.size() && (line[i] != ',' || isQuoted)) continue;
    std::string_view field = raster::trimmed(line.substr(start, i - start));
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
    fields.push_back(field);
    start = i + 1;
  }
  return fields;
}

bool isNamed(std::string_view field, std::initializer_list<std::string_view> names) {
  const auto sameLetter = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  return std::ranges::any_of(names, [&](std::string_view name) { return std::ranges::equal(field, name, sameLetter); });
}

}  // namespace

std::optional<LatLon> placeOfLine(std::string_view line) {
  const auto lat = takeNumber(line);
  line = raster::trimmed(line);
  if (line.starts_with(',')) line.remove_prefix(1);
  const auto lon = lat ? takeNumber(line) : std::nullopt;
  return lon && raster::trimmed(line).empty() ? checked(*lat, *lon) : std::nullopt;
}

PlaceLine PlaceReader::read(std::string_view line) {
  line = raster::trimmed(line);
  if (line.empty()) return {};
  if (isCsv_) return readCsv(line);
  const auto place = placeOfLine(line);
  if (place) return {.place = place};
  return {.complaint = fmt::format("'{}' is not 'LAT LON' or 'LAT,LON' in degrees", line.substr(0, 60))};
}

PlaceLine PlaceReader::readCsv(std::string_view line) {
  const std::vector<std::string_view> fields = fieldsOf(line);
  if (std::exchange(isFirst_, false)) {
    const auto lat = std::ranges::find_if(fields, [](auto f) { return isNamed(f, {"lat", "latitude"}); });
    const auto lon = std::ranges::find_if(fields, [](auto f) { return isNamed(f, {"lon", "lng", "longitude"}); });
    if (lat != fields.end() && lon != fields.end()) {
      latColumn_ = static_cast<std::size_t>(lat - fields.begin());
      lonColumn_ = static_cast<std::size_t>(lon - fields.begin());
      return {};
    }
  }
  if (std::max(latColumn_, lonColumn_) >= fields.size()) {
    return {.complaint = fmt::format("'{}' ends before the columns of latitude and longitude ({} and {})",
                                     line.substr(0, 60), latColumn_ + 1, lonColumn_ + 1)};
  }
  const auto lat = wholeNumber(fields[latColumn_]);
  const auto lon = wholeNumber(fields[lonColumn_]);
  const auto place = lat && lon ? checked(*lat, *lon) : std::nullopt;
  if (place) return {.place = place};
  return {.complaint = fmt::format("'{}' and '{}' are no latitude and longitude in degrees",
                                   fields[latColumn_].substr(0, 30), fields[lonColumn_].substr(0, 30))};
}

}  // namespace tellurion::app
