#include "tiling/octants.h"

#include <cmath>

namespace tellurion::tiling {

geo::SinCos sinCosOctants(double octants) {
  if (!(std::fabs(octants) < 1e9)) return {std::nan(""), std::nan("")};
  const int quarters = static_cast<int>(octants * 0.5 + (octants < 0.0 ? -0.5 : 0.5));
  return geo::sinCosQuarters(quarters, geo::Angle::radians((octants - 2.0 * quarters) * kRadiansPerOctant));
}

double octantsOf(double y, double x) {
  if (y == 0.0) return x < 0.0 ? 4.0 : 0.0 * x;
  return std::atan2(y, x) / kRadiansPerOctant;
}

}  // namespace tellurion::tiling
