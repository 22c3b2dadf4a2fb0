#include "scene/air_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

namespace tellurion::scene {
namespace {

using Code = io::Failure::Code;

struct Range {
  double low = 0.0;
  double high = 0.0;
};
constexpr Range kDepths{0.0, 100.0};
constexpr Range kShares{0.0, 1.0};
constexpr Range kForwards{-0.95, 0.95};
constexpr Range kScales_m{10.0, 1e6};
constexpr Range kHeights_m{0.0, 1e6};
constexpr Range kTops_m{100.0, 1e7};
constexpr Range kBottoms_m{-1e6, 0.0};
constexpr Range kSunRadii_degrees{0.001, 20.0};
constexpr Range kStops{-20.0, 20.0};
constexpr double kMostScales = 40.0;  ///< below height 0: twice as far, and densities are beyond what a float holds

struct NumberKey {
  std::string_view key;
  double Atmosphere::*field;
  Range range;
};
struct BandsKey {
  std::string_view key;
  ThreeBands Atmosphere::*field;
  Range range;
};
constexpr std::array kNumbers{NumberKey{"top_m", &Atmosphere::top_m, kTops_m},
                              NumberKey{"bottom_m", &Atmosphere::bottom_m, kBottoms_m},
                              NumberKey{"gas_height_m", &Atmosphere::gasHeight_m, kScales_m},
                              NumberKey{"aerosol_height_m", &Atmosphere::aerosolHeight_m, kScales_m},
                              NumberKey{"ozone_middle_m", &Atmosphere::ozoneMiddle_m, kHeights_m},
                              NumberKey{"ozone_reach_m", &Atmosphere::ozoneReach_m, kScales_m},
                              NumberKey{"sun_radius", &Atmosphere::sunRadius_degrees, kSunRadii_degrees}};
constexpr std::array kBands{BandsKey{"gas_depth", &Atmosphere::gasDepth, kDepths},
                            BandsKey{"aerosol_depth", &Atmosphere::aerosolDepth, kDepths},
                            BandsKey{"aerosol_albedo", &Atmosphere::aerosolAlbedo, kShares},
                            BandsKey{"aerosol_forward", &Atmosphere::aerosolForward, kForwards},
                            BandsKey{"ozone_depth", &Atmosphere::ozoneDepth, kDepths},
                            BandsKey{"ground_albedo", &Atmosphere::groundAlbedo, kShares}};
// Without these nothing is known of an atmosphere.
constexpr std::array<std::string_view, 3> kNeeded{"top_m", "gas_depth", "gas_height_m"};

tl::unexpected<io::Failure> wrong(std::string where, std::string message) {
  return io::fail(Code::invalidArgument, std::move(message), std::move(where));
}

bool within(double value, Range range) {
  return value >= range.low && value <= range.high;
}

std::string allKeys() {
  std::string keys = "enabled, model, exposure";
  for (const NumberKey& number : kNumbers)
    keys += fmt::format(", {}", number.key);
  for (const BandsKey& bands : kBands)
    keys += fmt::format(", {}", bands.key);
  return keys;
}

/// A number for all three colours, or one for each.
std::optional<ThreeBands> bandsFrom(const EntryField& field, Range range) {
  ThreeBands out{};
  if (const auto* one = std::get_if<double>(&field.value)) out.fill(*one);
  if (const auto* several = std::get_if<std::vector<double>>(&field.value)) {
    if (several->size() != out.size()) return std::nullopt;
    std::ranges::copy(*several, out.begin());
  } else if (!std::holds_alternative<double>(field.value)) {
    return std::nullopt;
  }
  return std::ranges::all_of(out, [&](double v) { return within(v, range); }) ? std::optional(out) : std::nullopt;
}

io::Result<void> readNumber(const EntryField& field, std::string_view key, Range range, double& out) {
  const auto* value = std::get_if<double>(&field.value);
  if (value == nullptr || !within(*value, range))
    return wrong(field.where, fmt::format("'{}' must be a number from {} to {}", key, range.low, range.high));
  out = *value;
  return {};
}

/// A key that is neither `enabled` nor `model`.
io::Result<void> readField(const EntryField& field, Air& air) {
  for (const NumberKey& number : kNumbers) {
    if (number.key == field.key) return readNumber(field, number.key, number.range, air.atmosphere.*number.field);
  }
  for (const BandsKey& bands : kBands) {
    if (bands.key != field.key) continue;
    const auto value = bandsFrom(field, bands.range);
    if (!value)
      return wrong(field.where, fmt::format("'{}' must be a number from {} to {}, or [red, green, blue] of such",
                                            bands.key, bands.range.low, bands.range.high));
    air.atmosphere.*bands.field = *value;
    return {};
  }
  if (field.key != "exposure")
    return wrong(field.where, fmt::format("unknown key '{}'; allowed here: {}", field.key, allKeys()));
  const auto* text = std::get_if<std::string>(&field.value);
  if (text != nullptr && *text == "auto") return {};
  const auto* stops = std::get_if<double>(&field.value);
  if (stops == nullptr || !within(*stops, kStops))
    return wrong(field.where,
                 fmt::format("'exposure' must be \"auto\", or stops from {} to {}", kStops.low, kStops.high));
  air.exposure_stops = *stops;
  return {};
}

const EntryField* find(std::span<const EntryField> fields, std::string_view key) {
  const auto found = std::ranges::find(fields, key, &EntryField::key);
  return found != fields.end() ? &*found : nullptr;
}

/// What all other keys change.
io::Result<Atmosphere> modelFor(std::span<const EntryField> fields, const std::string& where, const geo::Body& body) {
  if (const EntryField* field = find(fields, "model")) {
    const auto* name = std::get_if<std::string>(&field->value);
    const auto model = name != nullptr ? atmosphereByName(*name) : std::nullopt;
    if (!model) return wrong(field->where, "'model' must be \"earth\" or \"mars\"");
    return *model;
  }
  if (const auto own = atmosphereByName(body.name)) return *own;
  std::string missing;
  for (const std::string_view key : kNeeded) {
    if (find(fields, key) == nullptr) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", key);
  }
  if (!missing.empty())
    return wrong(where,
                 fmt::format("the air of '{}' is not known: give model = \"earth\" or \"mars\", or all of its own "
                             "(missing: {})",
                             body.name, missing));
  return Atmosphere{};
}

}  // namespace

io::Result<Air> readAir(std::span<const EntryField> fields, const std::string& where, const geo::Body& body) {
  Air air{.enabled = true, .atmosphere = {}, .exposure_stops = {}};
  if (const EntryField* field = find(fields, "enabled")) {
    const auto* value = std::get_if<bool>(&field->value);
    if (value == nullptr) return wrong(field->where, "'enabled' must be true or false");
    air.enabled = *value;
  }
  const auto model = modelFor(fields, where, body);
  if (!model) return tl::unexpected(model.error());
  air.atmosphere = *model;
  for (const EntryField& field : fields) {
    if (field.key == "enabled" || field.key == "model") continue;
    if (const auto read = readField(field, air); !read) return tl::unexpected(read.error());
  }
  const double radius_m = body.ellipsoid.meanRadius_m();
  const Atmosphere& a = air.atmosphere;
  if (a.top_m > radius_m || a.bottom_m < -0.5 * radius_m)
    return wrong(where,
                 fmt::format("the air reaches from {} m to {} m; around a body of {:.0f} m it may reach from half "
                             "of that below height 0 to as much above it: give top_m and bottom_m",
                             a.bottom_m, a.top_m, radius_m));
  if (const double least_m = -a.bottom_m / kMostScales; std::min(a.gasHeight_m, a.aerosolHeight_m) < least_m)
    return wrong(where, fmt::format("air from {} m on needs gas_height_m and aerosol_height_m of {:.0f} m or more: "
                                    "raise these, or bottom_m",
                                    a.bottom_m, std::ceil(least_m)));
  return air;
}

}  // namespace tellurion::scene
