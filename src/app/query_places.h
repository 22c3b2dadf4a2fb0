#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace tellurion::app {

/// Degrees, as given.
struct LatLon {
  double lat = 0.0;
  double lon = 0.0;
};

/// Exactly two numbers, blanks or one comma between them: a latitude within 90 degrees and a longitude within 720.
std::optional<LatLon> placeOfLine(std::string_view line);

/// What a line of places says.
struct PlaceLine {
  std::optional<LatLon> place;
  std::string complaint;  ///< why there is no place; empty too: nothing was asked (a blank line, a header)
};

/// Reads lines of places one after the other. Plain: placeOfLine. CSV: fields between commas, quoted or not; a first
/// line that names columns (lat or latitude, lon, lng or longitude; capitals do not matter) says where they are, else
/// they are the first two; further ones are let be.
class PlaceReader {
 public:
  explicit PlaceReader(bool isCsv) : isCsv_(isCsv) {}
  PlaceLine read(std::string_view line);

 private:
  PlaceLine readCsv(std::string_view line);

  bool isCsv_;
  bool isFirst_ = true;
  std::size_t latColumn_ = 0;
  std::size_t lonColumn_ = 1;
};

}  // namespace tellurion::app
