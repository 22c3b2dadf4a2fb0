#pragma once

#include <optional>
#include <vector>

#include "geo/geo_rect.h"

namespace tellurion::app {

/// W,S,E,N in degrees; E less than W crosses the date line. Nothing: these four are no such edges.
std::optional<geo::GeoRect> regionFrom(const std::vector<double>& edges);

/// What to say then.
inline constexpr const char* kNoRegion = "--region W,S,E,N: degrees, S less than N, W not E";

}  // namespace tellurion::app
