#include "pyramid/bounded_heights.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raster/height_band.h"

namespace tellurion::pyramid {

std::optional<double> stepForError(double maxError_m, const geo::Body& body) {
  if (!(maxError_m > 0.0)) return std::nullopt;
  const auto [lowest_m, highest_m] = raster::possibleHeights_m(body);
  const auto largest = static_cast<float>(std::max(std::abs(lowest_m), std::abs(highest_m)));
  const auto rounding_m =
      static_cast<double>(0.5f * (std::nextafter(largest, std::numeric_limits<float>::infinity()) - largest));
  // Three roundings: what is sampled, what is added to it (a vertical datum), what is stored.
  const double left_m = maxError_m - 3.0 * rounding_m;
  // Under ten roundings a step would hardly be wider than what 32-bit numbers have between them, and a height's
  // multiple could not be told from the rounded height again.
  return left_m < 10.0 * rounding_m ? 0.0 : 2.0 * left_m;
}

}  // namespace tellurion::pyramid
