#include "raster/tile.h"

#include <algorithm>

namespace tellurion::raster {

std::optional<Kind> kindByName(std::string_view name) {
  if (name == "elevation") return Kind::elevation;
  if (name == "imagery") return Kind::imagery;
  return std::nullopt;
}

std::string_view nameOf(Kind kind) {
  return kind == Kind::elevation ? "elevation" : "imagery";
}

HeightStatistics ownRangeOf(const Raster<float>& samples) {
  HeightStatistics range;
  for (int row = kGutter; row < samples.height - kGutter; ++row) {
    for (int column = kGutter; column < samples.width - kGutter; ++column) {
      const float height = samples.at(column, row);
      if (isNoData(height)) continue;
      range.min_m = isNoData(range.min_m) ? height : std::min(range.min_m, height);
      range.max_m = isNoData(range.max_m) ? height : std::max(range.max_m, height);
    }
  }
  return range;
}

}  // namespace tellurion::raster
