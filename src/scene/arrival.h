#pragma once

#include "scene/gazetteer.h"
#include "scene/parse_place.h"
#include "scene/picking.h"

// Where the eye goes when it is sent to a place.
namespace tellurion::scene {

/// What was written is kept. Without an attitude the eye looks straight down, north up; without a height it stays as
/// high above the ground as it is, but no higher than a six-hundredth of the body's radius (10 km on Earth).
View arrivalAt(const WrittenPlace& place, const View& now, const Ground& ground);
/// Straight above it, north up, so high that it fills two thirds of the picture's height; where its size is not known,
/// 20 km. At most three radii high.
View arrivalAt(const Place& place, const View& now, const Ground& ground);

}  // namespace tellurion::scene
