#pragma once

#include "scene/camera.h"
#include "scene/oriented_box.h"

namespace tellurion::scene {

/// How much of the picture the ground in a box covers, 0..1: what the box does, drawn half as high about its middle,
/// its last axis being the one that points up. The eye in it: the whole picture.
double screenShare(const OrientedBox& box, const View& view);

}  // namespace tellurion::scene
