#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace tellurion::scene {

/// Red, green and blue: the colours of 680, 550 and 440 nm.
using ThreeBands = std::array<double, 3>;

/// A planet's air: gas, aerosol (haze, dust) and ozone, each as dense as its height says and the same all round.
/// Heights are metres above the body's ellipsoid; optical depths are those of the whole air above height 0, straight
/// up. Gas and aerosol thin out by e in each scale height; ozone has its most at `ozoneMiddle_m` and none
/// `ozoneReach_m` away. Plain data; the ranges are those of readAir() (air_entry.h).
struct Atmosphere {
  double top_m = 0.0;                 ///< no air above
  double bottom_m = 0.0;              ///< <= 0, where the lowest ground lies: no air below
  ThreeBands gasDepth{};              ///< of Rayleigh scattering
  double gasHeight_m = 8000.0;        ///< scale height
  ThreeBands aerosolDepth{};          ///< of scattering and absorption together
  double aerosolHeight_m = 1200.0;    ///< scale height
  ThreeBands aerosolAlbedo{1, 1, 1};  ///< the share that is scattered
  ThreeBands aerosolForward{};        ///< mean cosine of the angle by which it is scattered (Henyey and Greenstein's g)
  ThreeBands ozoneDepth{};            ///< of absorption
  double ozoneMiddle_m = 25e3;
  double ozoneReach_m = 15e3;
  ThreeBands groundAlbedo{};          ///< of the whole body, for the light that ground and air throw to and fro
  double sunRadius_degrees = 0.2666;  ///< half of what the sun's disc spans in the sky

  friend bool operator==(const Atmosphere&, const Atmosphere&) = default;
};

/// Of "earth" and "mars", on a clear day; nothing for another name.
std::optional<Atmosphere> atmosphereByName(std::string_view name);

/// Whether, and how, a scene's air is drawn.
struct Air {
  bool enabled = false;
  Atmosphere atmosphere;
  /// Light is drawn 2^this times as bright; nothing: as the eye's place and the sun's height ask for (0 in space and by
  /// day, more in the dusk).
  std::optional<double> exposure_stops;
};

/// Where nothing is said of the air, gives it that of the body; false: nothing is known of that either.
bool knowAir(Air& air, std::string_view body);

}  // namespace tellurion::scene
