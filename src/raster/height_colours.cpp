#include "raster/height_colours.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tellurion::raster {
namespace {

constexpr std::array<ColourStop, 14> kEarth{{{-11000.0, {10, 22, 62, 255}},
                                             {-6000.0, {18, 48, 104, 255}},
                                             {-4000.0, {30, 78, 140, 255}},
                                             {-2000.0, {56, 116, 174, 255}},
                                             {-200.0, {122, 180, 214, 255}},
                                             {0.0, {186, 222, 236, 255}},
                                             {0.0, {82, 140, 88, 255}},
                                             {250.0, {136, 176, 104, 255}},
                                             {600.0, {202, 202, 136, 255}},
                                             {1200.0, {212, 180, 118, 255}},
                                             {2200.0, {178, 134, 88, 255}},
                                             {3400.0, {144, 108, 84, 255}},
                                             {4800.0, {190, 180, 174, 255}},
                                             {6500.0, {255, 255, 255, 255}}}};

constexpr std::array<ColourStop, 9> kMars{{{-8200.0, {30, 44, 92, 255}},
                                           {-5000.0, {60, 108, 140, 255}},
                                           {-3000.0, {116, 164, 150, 255}},
                                           {-1000.0, {204, 190, 132, 255}},
                                           {500.0, {214, 158, 98, 255}},
                                           {2500.0, {190, 114, 70, 255}},
                                           {5000.0, {146, 84, 60, 255}},
                                           {10000.0, {176, 146, 130, 255}},
                                           {21300.0, {255, 255, 255, 255}}}};

constexpr std::array<ColourStop, 5> kMoon{{{-9000.0, {34, 34, 52, 255}},
                                           {-4000.0, {74, 78, 98, 255}},
                                           {0.0, {140, 138, 130, 255}},
                                           {4000.0, {202, 194, 176, 255}},
                                           {10800.0, {255, 255, 255, 255}}}};

constexpr std::array<ColourStop, 2> kSlope{{{0.0, {255, 255, 255, 255}}, {90.0, {0, 0, 0, 255}}}};

std::uint8_t between(std::uint8_t low, std::uint8_t high, double share) {
  return static_cast<std::uint8_t>(std::lround(low + share * (high - low)));
}

}  // namespace

Rgba8 colourAt(std::span<const ColourStop> stops, double value) {
  if (stops.empty() || std::isnan(value)) return {};
  const auto above = std::upper_bound(stops.begin(), stops.end(), value,
                                      [](double v, const ColourStop& stop) { return v < stop.value; });
  if (above == stops.begin()) return stops.front().colour;
  if (above == stops.end()) return stops.back().colour;
  const ColourStop& low = *(above - 1);
  const double share = (value - low.value) / (above->value - low.value);
  return {between(low.colour.r, above->colour.r, share), between(low.colour.g, above->colour.g, share),
          between(low.colour.b, above->colour.b, share), between(low.colour.a, above->colour.a, share)};
}

std::span<const ColourStop> heightRamp(std::string_view name) {
  if (name == "earth") return kEarth;
  if (name == "mars") return kMars;
  if (name == "moon") return kMoon;
  return {};
}

std::span<const ColourStop> slopeRamp() {
  return kSlope;
}

geo::Vec3 sunOf(const Hillshade& hillshade) {
  const geo::SinCos azimuth = geo::sinCos(hillshade.sunAzimuth);
  const geo::SinCos altitude = geo::sinCos(hillshade.sunAltitude);
  return {altitude.cos * azimuth.sin, altitude.cos * azimuth.cos, altitude.sin};
}

Rgba8 shadeOf(const geo::Vec3& sun, double exaggeration, const Rise& rise) {
  const geo::Vec3 up(-exaggeration * rise.east, -exaggeration * rise.north, 1.0);
  const double light = geo::dot(sun, up) / geo::length(up);
  const auto grey = static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(light, 0.0, 1.0)));
  return {grey, grey, grey, 255};
}

geo::Angle slopeOf(const Rise& rise, double exaggeration) {
  return geo::Angle::radians(std::atan(exaggeration * std::hypot(rise.east, rise.north)));
}

}  // namespace tellurion::raster
