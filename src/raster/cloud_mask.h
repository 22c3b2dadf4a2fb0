#pragma once

#include <cstdint>

#include "raster/colour_match.h"

namespace tellurion::raster {

/// Nodes of a grid where `picture` is covered by clouds, by comparison with `clear`, a picture of the same ground
/// without them, as coarse as it may be: 1 cloud, 0 none. A cloud is where the picture is brighter than the clear one,
/// brought to its colours (matchColours), and whitish: by more than kCloudExcess of 255 in its darkest channel, or half
/// of that beside such a place; and what lies within two nodes of a cloud. So snow that only the picture has is a cloud
/// too. Where one of them has no data there is none. Colours are averaged over squares of the grid's steps.
io::Result<Raster<std::uint8_t>> findClouds(const ColourSampler& picture, const ColourSampler& clear,
                                            const LonLatGrid& grid);

inline constexpr double kCloudExcess = 36.0;

}  // namespace tellurion::raster
