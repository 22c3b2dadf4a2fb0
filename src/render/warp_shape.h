#pragma once

#include "geo/vector.h"
#include "scene/picture_projection.h"

namespace tellurion::render {

/// As warp_direction.glsl has it.
geo::Vec4f shapeOf(const scene::Warp& warp);

}  // namespace tellurion::render
