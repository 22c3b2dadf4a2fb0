#pragma once

#include "geo/ellipsoid.h"
#include "scene/frame.h"

// Where rays meet what a frame draws, in double precision: what a rasteriser with all the bits in the world would show.
namespace tellurion::truth {

/// Metres from a ray's origin to the nearest of the frame's triangles, from whichever side; infinite when it meets
/// none. Walks over all of them: for few rays.
double drawnAlong(const scene::Frame& frame, const geo::Ray& ray);

}  // namespace tellurion::truth
