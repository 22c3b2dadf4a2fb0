#include "scene/star_catalogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "geo/geodetic.h"
#include "raster/parse_number.h"
#include "scene/bright_stars.h"

namespace tellurion::scene {
namespace {

constexpr std::size_t kMostStars = 1'000'000;
constexpr std::uintmax_t kMostBytes = std::uintmax_t{256} << 20u;
constexpr double kBrightest = -30.0;  // brighter than the sun from here
constexpr double kFaintest = 40.0;
// Of known stars; beyond, the formula of temperatures is left.
constexpr double kBluest = -0.4;
constexpr double kReddest = 4.0;

std::uint64_t nextSerial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

/// Takes a line off the text, without its end.
std::string_view takeLine(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return raster::trimmed(line);
}

void fieldsOf(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(raster::trimmed(line.substr(0, comma)));
    if (comma == line.npos) return;
    line.remove_prefix(comma + 1);
  }
}

struct Column {
  std::string_view name;
  double low = 0.0;
  double high = 0.0;
  bool isNeeded = true;
};
constexpr std::array kColumns{Column{"ra_degrees", -360.0, 360.0}, Column{"dec_degrees", -90.0, 90.0},
                              Column{"magnitude", kBrightest, kFaintest}, Column{"bv", -10.0, 20.0, false}};
constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

io::Result<std::array<std::size_t, kColumns.size()>> columnsIn(const std::vector<std::string_view>& header,
                                                               const std::string& name) {
  std::array<std::size_t, kColumns.size()> places{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::ranges::find(header, kColumns[i].name);
    places[i] = found == header.end() ? kNowhere : static_cast<std::size_t>(found - header.begin());
    if (places[i] == kNowhere && kColumns[i].isNeeded)
      return io::fail(io::Failure::Code::invalidArgument,
                      fmt::format("there is no column '{}'; a catalogue of stars begins with a line "
                                  "'ra_degrees,dec_degrees,magnitude,bv', in any order",
                                  kColumns[i].name),
                      name + ":1");
  }
  return places;
}

}  // namespace

geo::Vec3f starColour(double colourIndex_bv) {
  constexpr std::array<double, 3> kWavelengths_m{612e-9, 549e-9, 465e-9};
  constexpr double kPlanck_mK = 1.438776877e-2;  // h c / k
  const double bv = std::clamp(colourIndex_bv, kBluest, kReddest);
  const double kelvin = 4600.0 * (1.0 / (0.92 * bv + 1.7) + 1.0 / (0.92 * bv + 0.62));
  // A black body of 6500 K is white, as sRGB's white is.
  const auto planck = [&](double wavelength_m, double t) { return 1.0 / std::expm1(kPlanck_mK / (wavelength_m * t)); };
  std::array<double, 3> light{};
  for (std::size_t i = 0; i < light.size(); ++i)
    light[i] = planck(kWavelengths_m[i], kelvin) / planck(kWavelengths_m[i], 6500.0);
  const double most = *std::ranges::max_element(light);
  return geo::Vec3f(geo::Vec3(light[0], light[1], light[2]) / most);
}

io::Result<StarCatalogue> readStars(std::string_view text, const std::string& name) {
  std::vector<std::string_view> fields;
  fieldsOf(takeLine(text), fields);
  const auto columns = columnsIn(fields, name);
  if (!columns) return tl::unexpected(columns.error());
  StarCatalogue out{.serial = nextSerial(), .stars = {}};
  for (std::size_t line = 2; !text.empty(); ++line) {
    const std::string_view content = takeLine(text);
    if (content.empty()) continue;
    fieldsOf(content, fields);
    std::array<std::optional<double>, kColumns.size()> values;
    for (std::size_t i = 0; i < kColumns.size(); ++i) {
      const Column& column = kColumns[i];
      const std::string_view field = (*columns)[i] < fields.size() ? fields[(*columns)[i]] : std::string_view{};
      values[i] = raster::parseNumber<double>(field);
      if (field.empty() && !column.isNeeded) continue;
      if (!values[i] || *values[i] < column.low || *values[i] > column.high)
        return io::fail(io::Failure::Code::invalidArgument,
                        fmt::format("'{}' must be a number from {} to {}, not '{}'", column.name, column.low,
                                    column.high, field.substr(0, 40)),
                        fmt::format("{}:{}", name, line));
    }
    if (out.stars.size() == kMostStars)
      return io::fail(io::Failure::Code::unsupported,
                      fmt::format("there are more than {} stars; leave the faint ones out", kMostStars), name);
    out.stars.push_back({.direction_celestial = geo::Vec3f(geo::directionFromDegrees(*values[1], *values[0]).n),
                         .magnitude = static_cast<float>(*values[2]),
                         .colour = values[3] ? starColour(*values[3]) : geo::Vec3f(1.0f)});
  }
  std::ranges::stable_sort(out.stars, {}, &Star::magnitude);
  return out;
}

io::Result<StarCatalogue> readStarFile(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error) return io::fail(io::Failure::Code::notFound, "there is no catalogue of stars: " + error.message(), path);
  if (bytes > kMostBytes)
    return io::fail(io::Failure::Code::unsupported,
                    fmt::format("a catalogue of stars may have {} MiB", kMostBytes >> 20u), path);
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file) return io::fail(io::Failure::Code::ioError, "the catalogue of stars cannot be read", path);
  return readStars(text, path);
}

std::shared_ptr<const StarCatalogue> brightStars() {
  static const auto catalogue = [] {
    auto read = readStars(kBrightStars, "bright_stars.csv");
    return std::make_shared<const StarCatalogue>(read ? std::move(*read) : StarCatalogue{});
  }();
  return catalogue;
}

}  // namespace tellurion::scene
