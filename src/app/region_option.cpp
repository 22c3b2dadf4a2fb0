#include "app/region_option.h"

#include <cmath>

namespace tellurion::app {

std::optional<geo::GeoRect> regionFrom(const std::vector<double>& edges) {
  const bool isPlace = edges.size() == 4 && std::abs(edges[0]) <= 360.0 && std::abs(edges[2]) <= 360.0 &&
                       edges[1] >= -90.0 && edges[3] <= 90.0 && edges[1] < edges[3] && edges[0] != edges[2];
  if (!isPlace) return std::nullopt;
  return geo::GeoRect::fromDegrees(edges[1], edges[0], edges[3], edges[2]);
}

}  // namespace tellurion::app
