#include "raster/tile.h"

#include <limits>

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
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  float lowest = kInfinity;
  float highest = -kInfinity;
  for (int row = kGutter; row < samples.height - kGutter; ++row) {
    for (const float height :
         samples.row(row).subspan(kGutter, static_cast<std::size_t>(samples.width - 2 * kGutter))) {
      // Written so that NaN changes nothing.
      lowest = height < lowest ? height : lowest;
      highest = height > highest ? height : highest;
    }
  }
  HeightStatistics range;
  if (lowest <= highest) {
    range.min_m = lowest;
    range.max_m = highest;
  }
  return range;
}

}  // namespace tellurion::raster
