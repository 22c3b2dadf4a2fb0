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

/// `top` laid over `bottom` (Porter and Duff's "over", not premultiplied), in linear light.
Rgba8 over(Rgba8 top, Rgba8 bottom);

}  // namespace tellurion::raster
