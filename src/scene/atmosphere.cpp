#include "scene/atmosphere.h"

namespace tellurion::scene {
namespace {

// Gas: Bodhaine and others, "On Rayleigh Optical Depth Calculations" (1999), at 1013.25 hPa. Ozone: 300 Dobson units
// with the cross sections of its Chappuis band. Aerosol: a clear day far from towns, coarser than it is small, so that
// it scatters blue light a little more than red.
constexpr Atmosphere kEarth{.top_m = 100e3,
                            .bottom_m = -500.0,
                            .gasDepth = {0.0410, 0.0971, 0.2426},
                            .gasHeight_m = 8400.0,
                            .aerosolDepth = {0.041, 0.050, 0.062},
                            .aerosolHeight_m = 1200.0,
                            .aerosolAlbedo = {0.94, 0.94, 0.94},
                            .aerosolForward = {0.76, 0.76, 0.76},
                            .ozoneDepth = {0.0098, 0.0282, 0.0013},
                            .ozoneMiddle_m = 25e3,
                            .ozoneReach_m = 15e3,
                            .groundAlbedo = {0.3, 0.3, 0.3},
                            .sunRadius_degrees = 0.2666};

// Gas: 6.1 hPa of carbon dioxide. Dust on a clear day: its reddish absorption, and a forward peak that is narrower in
// blue, after what the cameras of Mars Pathfinder saw (Tomasko and others, 1999). The sun has a blue aureole from it.
constexpr Atmosphere kMars{.top_m = 110e3,
                           .bottom_m = -8300.0,
                           .gasDepth = {0.0012, 0.0027, 0.0066},
                           .gasHeight_m = 11100.0,
                           .aerosolDepth = {0.45, 0.45, 0.45},
                           .aerosolHeight_m = 11100.0,
                           .aerosolAlbedo = {0.97, 0.87, 0.70},
                           .aerosolForward = {0.65, 0.70, 0.80},
                           .ozoneDepth = {0.0, 0.0, 0.0},
                           .groundAlbedo = {0.28, 0.16, 0.08},
                           .sunRadius_degrees = 0.175};

}  // namespace

std::optional<Atmosphere> atmosphereByName(std::string_view name) {
  if (name == "earth") return kEarth;
  if (name == "mars") return kMars;
  return std::nullopt;
}

bool knowAir(Air& air, std::string_view body) {
  if (air.atmosphere == Atmosphere{}) air.atmosphere = atmosphereByName(body).value_or(Atmosphere{});
  return air.atmosphere != Atmosphere{};
}

}  // namespace tellurion::scene
