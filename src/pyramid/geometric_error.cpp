#include "pyramid/geometric_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "raster/tile.h"

namespace tellurion::pyramid {
namespace {

using raster::kGutter;
using raster::Raster;

/// A position among samples: the one before it and the share of the one after it.
struct Between {
  int index;
  double share;
};

Between between(std::int64_t position, int levels, int cells) {
  const std::int64_t index = std::min(position >> levels, static_cast<std::int64_t>(cells) - 1);
  const double share = std::ldexp(static_cast<double>(position - (index << levels)), -levels);
  return {static_cast<int>(index), share};
}

/// NaN where a corner that has a weight has no data.
double surfaceAt(const Raster<float>& samples, const Between& column, const Between& row) {
  double sum = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double weight =
        ((i & 1) != 0 ? column.share : 1.0 - column.share) * ((i >> 1) != 0 ? row.share : 1.0 - row.share);
    if (weight == 0.0) continue;
    sum += weight * static_cast<double>(samples.at(column.index + (i & 1) + kGutter, row.index + (i >> 1) + kGutter));
  }
  return sum;
}

/// A bound of the distance from a height in a cell to a surface that has gaps there.
double distanceAtGap(const Raster<float>& samples, int column, int row, double height, const ErrorScale& scale) {
  constexpr std::array kReaches{0, 1, 2, 4, 8};
  for (const int reach : kReaches) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (int r = std::max(row + kGutter - reach, 0); r <= std::min(row + kGutter + 1 + reach, samples.height - 1);
         ++r) {
      for (int c = std::max(column + kGutter - reach, 0);
           c <= std::min(column + kGutter + 1 + reach, samples.width - 1); ++c) {
        if (raster::isNoData(samples.at(c, r))) continue;
        low = std::min(low, static_cast<double>(samples.at(c, r)));
        high = std::max(high, static_cast<double>(samples.at(c, r)));
      }
    }
    if (low > high) continue;
    const double beside = std::numbers::sqrt2 * (reach + 1) * scale.spacing_m;
    const double beyond = std::max({low - height, height - high, 0.0});
    return std::min(std::hypot(beside, beyond), std::max(scale.missing_m, beyond));
  }
  return scale.missing_m;
}

}  // namespace

double distanceToDescendant(const tiling::TileId& id, const Raster<float>& samples, const tiling::TileId& below,
                            const Raster<float>& samplesBelow, const ErrorScale& scale) {
  const int cells = samples.width - 1 - 2 * kGutter;
  const int levels = below.level - id.level;
  const std::int64_t x0 = (std::int64_t{below.x} - (std::int64_t{id.x} << levels)) * cells;
  const std::int64_t y0 = (std::int64_t{below.y} - (std::int64_t{id.y} << levels)) * cells;
  double largest = 0.0;
  for (int r = 0; r <= cells; ++r) {
    const Between row = between(y0 + r, levels, cells);
    for (int c = 0; c <= cells; ++c) {
      const float height = samplesBelow.at(c + kGutter, r + kGutter);
      if (raster::isNoData(height)) continue;
      const Between column = between(x0 + c, levels, cells);
      const double surface = surfaceAt(samples, column, row);
      const double distance = std::isnan(surface)
                                  ? distanceAtGap(samples, column.index, row.index, static_cast<double>(height), scale)
                                  : std::abs(static_cast<double>(height) - surface);
      largest = std::max(largest, distance);
    }
  }
  return largest;
}

float roundedUp(double value) {
  const auto nearest = static_cast<float>(value);
  if (static_cast<double>(nearest) >= value) return nearest;
  return std::nextafter(nearest, std::numeric_limits<float>::infinity());
}

}  // namespace tellurion::pyramid
