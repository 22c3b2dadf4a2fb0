#pragma once

#include <memory>

#include "scene/frame.h"
#include "scene/surface_grid.h"

namespace tellurion::scene {

/// Relief as frame.h describes it, one picture without further mip levels: shading normals of the ground by central
/// differences over the gutter, minus the ellipsoid's. Where three tiles meet at a corner the normal is that of the
/// triangle of the three samples next to it.
std::shared_ptr<const TextureImage> makeRelief(const SurfaceGrid& grid);

}  // namespace tellurion::scene
