#include "scene/gazetteer.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <optional>
#include <sstream>

#include "raster/parse_number.h"
#include "scene/folded_text.h"

namespace tellurion::scene {
namespace {

constexpr std::size_t kMostPlaces = 1'000'000;
constexpr std::uintmax_t kMostBytes = 256U << 20U;
constexpr std::size_t kLongestName = 200;
constexpr std::size_t kMostColumns = 1000;
constexpr std::size_t kLongestRecord = 256U << 10U;

std::string lowered(std::string_view text) {
  std::string out(raster::trimmed(text));
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// The next record (RFC 4180); takes it off the text. Nothing: it is longer, or has more columns, than any of places.
std::optional<std::vector<std::string>> takeRecord(std::string_view& text, int& lines) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  std::size_t i = 0;
  for (; i < text.size(); ++i) {
    const char c = text[i];
    if (i == kLongestRecord || fields.size() > kMostColumns) return std::nullopt;
    if (c == '\n') ++lines;
    if (quoted && c == '"' && i + 1 < text.size() && text[i + 1] == '"') {
      fields.back() += c;
      ++i;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (quoted) {
      fields.back() += c;
    } else if (c == ',') {
      fields.emplace_back();
    } else if (c == '\n') {
      ++i;
      break;
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  text.remove_prefix(i);
  return fields;
}

class Columns {
 public:
  explicit Columns(const std::vector<std::string>& header) {
    for (const std::string& field : header)
      names_.push_back(lowered(field));
    if (!names_.empty() && names_[0].starts_with("\xef\xbb\xbf")) names_[0].erase(0, 3);
  }

  std::optional<std::size_t> of(std::initializer_list<std::string_view> aliases) const {
    for (const std::string_view alias : aliases) {
      const auto found = std::ranges::find(names_, alias);
      if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
    }
    return std::nullopt;
  }

 private:
  std::vector<std::string> names_;
};

std::string_view fieldOf(const std::vector<std::string>& record, std::optional<std::size_t> column) {
  return column && *column < record.size() ? raster::trimmed(record[*column]) : std::string_view();
}

/// 0 is best; nothing: it does not fit.
std::optional<int> rankOf(std::string_view name, std::string_view query) {
  if (name == query) return 0;
  const std::size_t at = name.find(query);
  if (at == name.npos) return std::nullopt;
  if (at == 0) return 1;
  for (std::size_t i = at; i != name.npos; i = name.find(query, i + 1))
    if (name[i - 1] == ' ') return 2;
  return 3;
}

}  // namespace

io::Result<void> Gazetteer::add(std::string_view csv, const std::string& body, const std::string& file) {
  int line = 1;
  const auto wrong = [&file](int at, std::string message) {
    return io::fail(io::Failure::Code::invalidArgument, std::move(message), fmt::format("{}:{}", file, at));
  };
  const std::string tooLong = "a line of more than 1000 columns or 256 KiB is none of places; is a quote open?";
  const auto header = takeRecord(csv, line);
  if (!header) return wrong(1, tooLong);
  const Columns columns(*header);
  const auto name = columns.of({"name", "feature_name", "clean_name", "nameascii"});
  const auto lat = columns.of({"lat", "latitude", "center_latitude", "y"});
  const auto lon = columns.of({"lon", "lng", "long", "longitude", "center_longitude", "x"});
  const auto size = columns.of({"size_km", "diameter_km", "diameter"});
  const auto population = columns.of({"population", "pop_max"});
  const auto kind = columns.of({"kind", "feature_type", "featurecla"});
  const auto target = columns.of({"body", "target"});
  if (!name || !lat || !lon)
    return wrong(1, "the first line must name the columns, with name, lat and lon among them (docs/viewer.md)");
  while (!csv.empty()) {
    const int at = line;
    const auto taken = takeRecord(csv, line);
    if (!taken) return wrong(at, tooLong);
    const auto& record = *taken;
    if (record.size() == 1 && raster::trimmed(record[0]).empty()) continue;
    if (target && lowered(fieldOf(record, target)) != lowered(body)) continue;
    Place place{.name = std::string(fieldOf(record, name)), .kind = std::string(fieldOf(record, kind))};
    const auto latitude = raster::parseNumber<double>(fieldOf(record, lat));
    const auto longitude = raster::parseNumber<double>(fieldOf(record, lon));
    if (place.name.empty() || place.name.size() > kLongestName)
      return wrong(at, "a place needs a name of up to 200 bytes");
    if (!latitude || std::abs(*latitude) > 90.0)
      return wrong(at, "the latitude is not a number within -90..90 degrees");
    if (!longitude || std::abs(*longitude) > 360.0)
      return wrong(at, "the longitude is not a number within -360..360 degrees");
    if (places_.size() == kMostPlaces) return wrong(at, "more than a million places");
    place.lat = geo::Angle::degrees(*latitude);
    place.lon = geo::wrappedLongitude(geo::Angle::degrees(*longitude));
    place.size_m = 1000.0 * std::clamp(raster::parseNumber<double>(fieldOf(record, size)).value_or(0.0), 0.0, 1e6);
    place.weight = raster::parseNumber<double>(fieldOf(record, population)).value_or(place.size_m);
    folded_.push_back(foldedText(place.name));
    places_.push_back(std::move(place));
  }
  return {};
}

io::Result<void> Gazetteer::addFile(const std::string& path, const std::string& body) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(path, error);
  if (error) return io::fail(io::Failure::Code::notFound, "the places cannot be read: " + error.message(), path);
  if (bytes > kMostBytes) return io::fail(io::Failure::Code::invalidArgument, "more than 256 MiB of places", path);
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return io::fail(io::Failure::Code::ioError, "the places cannot be read", path);
  return add(text.str(), body, path);
}

std::vector<const Place*> Gazetteer::search(std::string_view query, std::size_t most) const {
  struct Match {
    int rank;
    const Place* place;
  };
  const std::string folded = foldedText(query);
  std::vector<Match> matches;
  if (folded.empty()) return {};
  for (std::size_t i = 0; i < places_.size(); ++i)
    if (const auto rank = rankOf(folded_[i], folded)) matches.push_back({*rank, &places_[i]});
  const auto before = [](const Match& a, const Match& b) {
    if (a.rank != b.rank) return a.rank < b.rank;
    if (a.place->weight != b.place->weight) return a.place->weight > b.place->weight;
    return a.place->name < b.place->name;
  };
  const std::size_t count = std::min(most, matches.size());
  std::partial_sort(matches.begin(), matches.begin() + static_cast<std::ptrdiff_t>(count), matches.end(), before);
  std::vector<const Place*> found;
  for (std::size_t i = 0; i < count; ++i)
    found.push_back(matches[i].place);
  return found;
}

}  // namespace tellurion::scene
