#pragma once

#include "scene/frame.h"

namespace tellurion::scene {

/// Where a vertex of a drawn tile is drawn, body coordinates: what the vertex shader computes, in the same order, but
/// relative to the body's centre and in double precision. For whoever must agree with the picture (picking, walking,
/// tests).
geo::BodyPosition drawnPosition(const DrawnTile& tile, const TerrainVertex& vertex, const Frame& frame);

}  // namespace tellurion::scene
