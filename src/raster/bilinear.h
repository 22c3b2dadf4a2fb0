#pragma once

#include <array>
#include <optional>

namespace tellurion::raster {

/// The height between the four corners of a cell (top left, top right, bottom left, bottom right; NaN is NODATA), s to
/// the right and t downwards from the first, both 0..1. Nothing where the nearest corner, of several equally near ones
/// any, has no data; else the weights are shared among those that have. The same bits for a cell that is turned or
/// mirrored where one of s and t is 0 or 1, so both sides of a border agree.
std::optional<double> bilinearHeight(const std::array<double, 4>& corners, double s, double t);

}  // namespace tellurion::raster
