#include "tiling/octants.h"

#include <cmath>

namespace tellurion::tiling {

geo::SinCos sinCosOctants(double octants) {
  if (!(std::fabs(octants) < 1e9)) return {std::nan(""), std::nan("")};
  const int quarters = static_cast<int>(octants * 0.5 + (octants < 0.0 ? -0.5 : 0.5));
  const double rest = (octants - 2.0 * quarters) * kRadiansPerOctant;
  const double s = std::sin(rest);
  const double c = std::cos(rest);
  switch (quarters & 3) {
    case 0:
      return {s + 0.0, c + 0.0};
    case 1:
      return {c + 0.0, -s + 0.0};
    case 2:
      return {-s + 0.0, -c + 0.0};
    default:
      return {-c + 0.0, s + 0.0};
  }
}

double octantsOf(double y, double x) {
  if (y == 0.0) return x < 0.0 ? 4.0 : 0.0 * x;
  return std::atan2(y, x) / kRadiansPerOctant;
}

}  // namespace tellurion::tiling
