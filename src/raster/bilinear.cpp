#include "raster/bilinear.h"

#include <algorithm>
#include <cmath>

namespace tellurion::raster {

std::optional<double> bilinearHeight(const std::array<double, 4>& corners, double s, double t) {
  double sum = 0.0;
  double weights = 0.0;
  double heaviest = 0.0;
  double heaviestWithoutData = -1.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double weight = ((i & 1u) != 0 ? s : 1.0 - s) * ((i >> 1u) != 0 ? t : 1.0 - t);
    heaviest = std::max(heaviest, weight);
    if (std::isnan(corners[i])) {
      heaviestWithoutData = std::max(heaviestWithoutData, weight);
    } else if (weight != 0.0) {
      sum += weight * corners[i];
      weights += weight;
    }
  }
  if (heaviestWithoutData >= heaviest) return std::nullopt;
  return sum / weights;
}

}  // namespace tellurion::raster
