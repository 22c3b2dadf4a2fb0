#pragma once

#include "scene/camera.h"
#include "scene/scene_file.h"

namespace tellurion::app {

/// Where the viewer begins when nobody says: straight above the middle of the scene's data, high enough to see all of
/// it; the whole body where the data go around more than a third of it, or lie nobody knows where.
scene::Camera startCamera(const scene::Scene& scene, geo::Angle verticalFov);

}  // namespace tellurion::app
