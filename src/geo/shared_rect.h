#pragma once

#include <optional>

#include "geo/geo_rect.h"

namespace tellurion::geo {

/// What both hold; nothing where they do not meet. Where they meet twice on their way around, or at a pole alone, it
/// has the longitudes of the narrower one, which hold both parts.
std::optional<GeoRect> sharedRect(const GeoRect& a, const GeoRect& b);

}  // namespace tellurion::geo
