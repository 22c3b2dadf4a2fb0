#include "pyramid/geometric_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "raster/tile.h"

namespace tellurion::pyramid {
namespace {

using raster::kGutter;
using raster::Raster;

/// A position among samples: the one before it and the share of the one after it, which is the same one where it has
/// no share, so that it may have no data.
struct Between {
  int index;
  int next;
  double share;
};

Between between(std::int64_t position, int levels) {
  const auto index = static_cast<int>(position >> levels);
  const std::int64_t beyond = position - (std::int64_t{index} << levels);
  return {.index = index,
          .next = beyond == 0 ? index : index + 1,
          .share = static_cast<double>(beyond) / static_cast<double>(std::int64_t{1} << levels)};
}

/// NaN where a corner that has a share has no data. Of two rows, without their gutters.
double surfaceAt(const float* upper, const float* lower, const Between& column, double rowShare) {
  const double left = 1.0 - column.share;
  const double top = 1.0 - rowShare;
  return left * top * static_cast<double>(upper[column.index]) +
         column.share * top * static_cast<double>(upper[column.next]) +
         left * rowShare * static_cast<double>(lower[column.index]) +
         column.share * rowShare * static_cast<double>(lower[column.next]);
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
  std::vector<Between> columns;
  for (int c = 0; c <= cells; ++c)
    columns.push_back(between(x0 + c, levels));
  double largest = 0.0;
  for (int r = 0; r <= cells; ++r) {
    const Between row = between(y0 + r, levels);
    const float* upper = samples.row(row.index + kGutter).data() + kGutter;
    const float* lower = samples.row(row.next + kGutter).data() + kGutter;
    const float* heights = samplesBelow.row(r + kGutter).data() + kGutter;
    for (int c = 0; c <= cells; ++c) {
      const float height = heights[c];
      if (raster::isNoData(height)) continue;
      const Between& column = columns[static_cast<std::size_t>(c)];
      const double surface = surfaceAt(upper, lower, column, row.share);
      const double distance = std::isnan(surface)
                                  ? distanceAtGap(samples, std::min(column.index, cells - 1),
                                                  std::min(row.index, cells - 1), static_cast<double>(height), scale)
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
