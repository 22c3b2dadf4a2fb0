#pragma once

#include <optional>

#include "geo/ellipsoid.h"
#include "scene/frame.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// Height in metres above the ellipsoid of the triangles that a frame draws over a place; nothing where it draws no
/// tile (the place is out of view). While data load, and where a mesh leaves out samples, it differs from the finest
/// ground that is known; who must not enter what is seen asks for both. Costs a few walks over one tile's triangles, tens
/// of microseconds each.
std::optional<double> drawnHeight_m(const Frame& frame, const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                    const geo::Direction& place);

/// The point of the drawn ground at a place's (s, t) in its tile: over it but for what chords shift sideways.
std::optional<geo::BodyPosition> drawnPoint(const Frame& frame, const tiling::Tiling& tiling,
                                            const geo::Direction& place);

}  // namespace tellurion::scene
