#pragma once

#include <vector>

#include "scene/bisection.h"

namespace tellurion::scene {

/// The outline of triangles that together make one region without holes, counter-clockwise. Pure, quadratic in their
/// number.
std::vector<GridPoint> outlineOf(const std::vector<GridTriangle>& region);

/// Adds triangles that fill a simple polygon, given counter-clockwise; straight angles are allowed. Ear clipping, exact
/// (whole numbers), the ear that is cut off along the shortest line first: so no triangle reaches further along a strip
/// than it must, over ground that it knows nothing of. Of a polygon that crosses itself some triangles may overlap.
void fillPolygon(std::vector<GridPoint> outline, std::vector<GridTriangle>& out);

}  // namespace tellurion::scene
