#include "scene/air_entry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>

namespace tellurion::scene {
namespace {

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

std::optional<double> numberIn(const Entry& entry, Range range) {
  const auto value = numberOf(entry);
  return value && within(*value, range) ? value : std::nullopt;
}

/// A number for all three colours, or one for each.
std::optional<ThreeBands> bandsFrom(const Entry& entry, Range range) {
  ThreeBands out{};
  const bool isList = entry.shape == Entry::Shape::list;
  if (isList && entry.parts.size() != out.size()) return std::nullopt;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto value = numberIn(isList ? entry.parts[i] : entry, range);
    if (!value) return std::nullopt;
    out[i] = *value;
  }
  return out;
}

/// A key that is neither `enabled` nor `model`.
void readField(const Entry& field, Air& air) {
  for (const NumberKey& number : kNumbers) {
    if (number.key != field.key) continue;
    air.atmosphere.*number.field = asNumber(field, number.range.low, number.range.high);
    return;
  }
  for (const BandsKey& bands : kBands) {
    if (bands.key != field.key) continue;
    const auto value = bandsFrom(field, bands.range);
    if (!value)
      complain(field.where, fmt::format("'{}' must be a number from {} to {}, or [red, green, blue] of such", bands.key,
                                        bands.range.low, bands.range.high));
    air.atmosphere.*bands.field = *value;
    return;
  }
  if (field.key != "exposure")
    complain(field.where, fmt::format("unknown key '{}'; allowed here: {}", field.key, allKeys()));
  if (field.isText() && asText(field) == "auto") return;
  const auto stops = numberIn(field, kStops);
  if (!stops)
    complain(field.where, fmt::format("'exposure' must be \"auto\", or stops from {} to {}", kStops.low, kStops.high));
  air.exposure_stops = *stops;
}

/// What all other keys change.
Atmosphere modelFor(const Entry& table, const geo::Body& body) {
  if (const Entry* field = find(table, "model")) {
    const auto model = field->isText() ? atmosphereByName(asText(*field)) : std::nullopt;
    if (!model) complain(field->where, "'model' must be \"earth\" or \"mars\"");
    return *model;
  }
  if (const auto own = atmosphereByName(body.name)) return *own;
  std::string missing;
  for (const std::string_view key : kNeeded) {
    if (find(table, key) == nullptr) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", key);
  }
  if (!missing.empty())
    complain(table.where,
             fmt::format("the air of '{}' is not known: give model = \"earth\" or \"mars\", or all of its own "
                         "(missing: {})",
                         body.name, missing));
  return Atmosphere{};
}

}  // namespace

Air readAir(const Entry& table, const geo::Body& body) {
  Air air{.enabled = booleanAt(table, "enabled", true), .atmosphere = modelFor(table, body), .exposure_stops = {}};
  for (const Entry& field : table.parts) {
    if (field.key != "enabled" && field.key != "model") readField(field, air);
  }
  const double radius_m = body.ellipsoid.meanRadius_m();
  const Atmosphere& a = air.atmosphere;
  if (a.top_m > radius_m || a.bottom_m < -0.5 * radius_m)
    complain(table.where,
             fmt::format("the air reaches from {} m to {} m; around a body of {:.0f} m it may reach from half "
                         "of that below height 0 to as much above it: give top_m and bottom_m",
                         a.bottom_m, a.top_m, radius_m));
  if (const double least_m = -a.bottom_m / kMostScales; std::min(a.gasHeight_m, a.aerosolHeight_m) < least_m)
    complain(table.where, fmt::format("air from {} m on needs gas_height_m and aerosol_height_m of {:.0f} m or more: "
                                      "raise these, or bottom_m",
                                      a.bottom_m, std::ceil(least_m)));
  return air;
}

}  // namespace tellurion::scene
