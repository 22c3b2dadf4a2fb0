#pragma once

#include <array>

#include "render/air_model.h"
#include "scene/camera.h"

namespace tellurion::render {

/// What of the sky's dome (shaders/sky.vert.glsl) a picture needs.
struct SkyPart {
  /// Rows of the dome where bands end, from below the horizon up; the first bandCount + 1 count.
  std::array<int, air_shading::kSkyBands + 1> rows{};
  int bandCount = 0;
  int firstColumn = 0;  ///< 0 to kSkyColumns - 1; columns go on beyond the last at the first
  int columnCount = 2;  ///< at least 2: the sun's disc takes as many vertices
};

/// Rows that would lie within half a pixel of each other are left out, and bands and columns beside the picture. Pure.
SkyPart skyPartOf(const scene::View& view, const air_shading::AirView& air);

}  // namespace tellurion::render
