#pragma once

#include <cstdint>
#include <span>

#include "tiling/tiling.h"

namespace tellurion::tiling {

/// HEALPix NESTED pixels and their centres without tiles in between, one by one and many at once. `order` is 0 to
/// kMaxLevel; pixels are below 12 * 4^order. Thread-safe.

/// The pixel that holds a direction (a unit vector): that of Tiling::tileAt, so on a border that of the lowest base
/// pixel. NaN and infinities give a pixel that there is.
std::uint64_t healpixNestedAt(const geo::Direction& d, int order);
/// The same for each of `directions`, into `pixels`, which is as long: to the last bit what they give one by one.
void healpixNestedAt(std::span<const geo::Direction> directions, int order, std::span<std::uint64_t> pixels);

/// The middle of a pixel, a unit vector.
geo::Direction healpixCentre(std::uint64_t pixel, int order);
/// The same for each of `pixels`, into `centres`, which is as long: to the last bit what they give one by one.
void healpixCentres(std::span<const std::uint64_t> pixels, int order, std::span<geo::Direction> centres);

}  // namespace tellurion::tiling
