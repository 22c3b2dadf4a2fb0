#pragma once

#include "scene/camera.h"
#include "scene/oriented_box.h"

namespace tellurion::scene {

/// How much of the picture a box covers at most, 0..1: of the rectangle around it. One that reaches behind the eye
/// counts as the whole picture.
double screenShare(const OrientedBox& box, const View& view);

}  // namespace tellurion::scene
