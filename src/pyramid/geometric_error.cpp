#include "pyramid/geometric_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// NaN where no corner with a weight has data.
double surfaceAt(const Raster<float>& samples, const Between& column, const Between& row) {
  double sum = 0.0;
  double weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double weight =
        ((i & 1) != 0 ? column.share : 1.0 - column.share) * ((i >> 1) != 0 ? row.share : 1.0 - row.share);
    const float height = samples.at(column.index + (i & 1) + kGutter, row.index + (i >> 1) + kGutter);
    if (weight == 0.0 || raster::isNoData(height)) continue;
    sum += weight * static_cast<double>(height);
    weights += weight;
  }
  return weights > 0.0 ? sum / weights : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

double distanceToDescendant(const tiling::TileId& id, const Raster<float>& samples, const tiling::TileId& below,
                            const Raster<float>& samplesBelow, double missing_m) {
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
      const double surface = surfaceAt(samples, between(x0 + c, levels, cells), row);
      const double distance = std::isnan(surface) ? missing_m : std::abs(static_cast<double>(height) - surface);
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
