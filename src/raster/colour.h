#pragma once

#include <cstdint>

#include "raster/raster.h"

namespace tellurion::raster {

/// Linear light of an sRGB value, both 0..1 (IEC 61966-2-1). NaN in, NaN out.
double linearLight(double srgb);

/// Linear light in 0..65535 of an sRGB byte, and the byte nearest to a linear value. Each byte comes
/// back as itself. Table lookups.
std::uint16_t linearFromSrgb(std::uint8_t value);
std::uint8_t srgbFromLinear(std::uint16_t linear);

/// The tables behind the two functions, for loops over pixels: neither a call nor a check for each look-up.
struct ColourTables {
  const std::uint16_t* linear;  ///< of 256 bytes
  const std::uint8_t* srgb;     ///< of 65536 linear values
};
ColourTables colourTables();

/// `top` laid over `bottom` (Porter and Duff's "over", not premultiplied), in linear light.
Rgba8 over(Rgba8 top, Rgba8 bottom);

}  // namespace tellurion::raster
