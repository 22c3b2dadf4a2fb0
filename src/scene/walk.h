#pragma once

#include "scene/navigation.h"

// An eye that walks over the ground or flies above it while keys are held. Pure functions of the time that has passed:
// the way is the same at any rate of frames, for it is taken in steps of a fixed length within a call. Shared rules:
//  - The way over the ground is the geodesic ahead: latitude and longitude change by the ellipsoid's radii of curvature
//    at the eye, and what is ahead is carried along in parallel. So straight on is straight on, also over a pole; the
//    heading that is shown changes as that of a great circle does. Pitch and roll stay.
//  - The eye stays at least kClearance_m above the ground, and at most as high as kHighest_radii says.
//  - Where no ground is known the ellipsoid counts. Arguments are finite, seconds >= 0.
namespace tellurion::scene {

/// What is asked for, each from -1 to 1; longer than 1 together it is shortened to 1.
struct Stride {
  double ahead = 0.0;
  double right = 0.0;
  double up = 0.0;  ///< only an eye that flies heeds it

  bool rests() const { return ahead == 0.0 && right == 0.0 && up == 0.0; }
};

/// The eye of a walker is kClearance_m above the ground: what all motions keep, and what the nearest plane of the
/// picture is made for.
struct Walker {
  View view;
  double climb_mps = 0.0;  ///< its vertical speed
};

/// Walks at a level speed (metres a second at the height of the eye) along the heading, whatever the pitch. The eye
/// begins to rise 0.4 s before higher ground, so a slope or a step does not jolt it; above the ground it sinks as
/// Earth's gravity lets it at first (9.81 m/s^2 on every body) and settles without a bounce. Ground that has come to
/// lie above it lifts it at once.
Walker walked(const Walker& start, const Stride& stride, double speed_mps, double seconds, const Ground& ground);

/// Whether the walker is on the ground and stays so.
bool stands(const Walker& walker, const Ground& ground);

/// Flies along the view, its pitch included, level flight keeping the height above the ellipsoid. `rate` is the speed
/// as a part of the height above the ground per second, which is taken for at least kClearance_m: 0.5 takes two seconds
/// for a way as long as the eye is high. Along the ground it slides.
View flown(const View& start, const Stride& stride, double rate, double seconds, const Ground& ground);

}  // namespace tellurion::scene
