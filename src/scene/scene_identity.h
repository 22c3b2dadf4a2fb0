#pragma once

#include <string>
#include <string_view>

#include "scene/scene_file.h"

namespace tellurion::scene {

/// What scenes must have in common for their pictures to be parts of one: body, tiling, air and sky, and each layer
/// with the name of its source and, of a file, its size. A line each; sources without their folders and secrets.
std::string identityOf(const Scene& scene);
/// The first line in which they differ, for people; empty: none.
std::string differenceOf(std::string_view leaders, std::string_view own);

}  // namespace tellurion::scene
