#pragma once

#include <cstdint>

#include "raster/colour_match.h"

namespace tellurion::raster {

/// Nodes of a grid where `picture` is covered by clouds, by comparison with `clear`, a picture of the same ground
/// without them: 1 cloud, 0 none. A cloud is whitish, and in its darkest channel brighter than the clear picture,
/// brought to its colours (matchColours), by more than kCloudExcess of 255 and by more than three standard
/// deviations of what the two usually differ by (so that the fields of a sharp picture are no clouds over a coarse map;
/// told from the upper quartile, so clouds over more than a quarter of the picture are taken for usual); or 0.7 of that
/// beside such a place; and what lies beside a cloud. So snow that only the picture has is a cloud too,
/// and haze and shadows of clouds are none. Where one of them has no data there is none. Colours are averaged over
/// squares of the grid's steps.
io::Result<Raster<std::uint8_t>> findClouds(const ColourSampler& picture, const ColourSampler& clear,
                                            const LonLatGrid& grid);

inline constexpr double kCloudExcess = 36.0;

}  // namespace tellurion::raster
