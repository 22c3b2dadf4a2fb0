#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "geo/angle.h"
#include "geo/vector.h"
#include "raster/raster.h"

/// Colours out of heights, a place at a time. Pure functions, thread-safe.
namespace tellurion::raster {

/// A colour and the number that it stands for: metres, or degrees of slope.
struct ColourStop {
  double value = 0.0;
  Rgba8 colour;
};

/// Linear between the stops, in sRGB numbers as colour ramps of maps are made; beyond them the first and the last.
/// Stops ascend; of two with one value the later counts from there on. No stops, or NaN: transparent.
Rgba8 colourAt(std::span<const ColourStop> stops, double value);

/// Hypsometric tints of "earth" (with the sea's depths), "mars", "moon": metres. Empty: no such name.
std::span<const ColourStop> heightRamp(std::string_view name);
/// White on the level to black at 90 degrees.
std::span<const ColourStop> slopeRamp();

/// Light from one side on ground without a colour: grey 255 where it falls straight on, 0 in its own shade. Nothing
/// casts shadows on other ground.
struct Hillshade {
  geo::Angle sunAzimuth = geo::Angle::degrees(315.0);  ///< of where the light comes from, clockwise from north
  geo::Angle sunAltitude = geo::Angle::degrees(45.0);  ///< over the horizon
  double exaggeration = 1.0;                           ///< of heights
};

/// The angle between ground and horizontal, coloured.
struct SlopeColours {
  std::vector<ColourStop> stops;  ///< degrees, 0..90
  double exaggeration = 1.0;
};

/// The height, coloured.
struct Palette {
  std::vector<ColourStop> stops;  ///< metres
};

using HeightColours = std::variant<Hillshade, SlopeColours, Palette>;

/// How much the ground rises, metres a metre.
struct Rise {
  double east = 0.0;
  double north = 0.0;
};

/// A unit vector to the sun: east, north, up.
geo::Vec3 sunOf(const Hillshade& hillshade);
Rgba8 shadeOf(const geo::Vec3& sun, double exaggeration, const Rise& rise);
geo::Angle slopeOf(const Rise& rise, double exaggeration);

}  // namespace tellurion::raster
