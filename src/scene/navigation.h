#pragma once

#include <optional>

#include "scene/picking.h"

namespace tellurion::scene {

// How a camera is moved by hand. Pure functions: the view at the start of a gesture and what the hand did give the view
// now, so a hand that comes back to where it began finds the first view again. Shared rules:
//  - The eye stays at least kClearance_m above the ground, also where the ground has just arrived (`cleared`).
//  - Roll stays what it was. Heading stays what it was unless a pole is near (from 20 degrees of it on it begins to
//  turn,
//    within 10 it turns freely), where keeping it would spin the picture.
//  - The held point (Grip) falls on its pixel to better than 0.01 px, as long as the eye is not pushed up by the
//  ground.
//  - Arguments are finite; a view that cannot be had (no such place for the eye) comes back as the nearest that can.

/// The least height of the eye above the ground under it.
inline constexpr double kClearance_m = 2.0;
/// The greatest height above the ellipsoid, in equatorial radii.
inline constexpr double kHighest_radii = 20.0;
/// What is left of the distance after one step of zooming in.
inline constexpr double kZoomStep = 0.9;

/// A point of the body held at a place on the picture.
struct Grip {
  PixelPosition pixel;
  geo::BodyPosition point;
};

/// The least height of the eye above the ellipsoid at a place, in metres.
double leastHeight_m(const geo::Direction& place, const Ground& ground);
/// The greatest.
double greatestHeight_m(const Ground& ground);

/// Takes hold of what lies under the cursor; nothing in the sky.
std::optional<Grip> gripAt(const View& view, PixelPosition pixel, const Ground& ground);

/// Moves the eye at constant height and pitch so that the held point comes to `cursor`. Where the cursor has left the
/// body, or come so near its rim that the eye would have to fly further than 30 times the point's distance, the point
/// stays at the last good place on the straight line between.
View panned(const View& start, const Grip& grip, PixelPosition cursor, const Ground& ground);

/// Goes towards the held point (steps > 0) or away from it, kZoomStep of the distance a step, keeping it at its pixel.
/// Pitch is kept where possible. Far out, where the body is too small to reach the pixel, the eye goes straight back
/// and turns instead; the point leaves its pixel only where the eye then looks straight down and would have to lean
/// back further. The distance never falls under twice the clearance.
View zoomed(const View& start, const Grip& grip, double steps, const Ground& ground);

/// Zoom with nothing under the cursor: straight down or up, kZoomStep of the height above the ground a step.
View climbed(const View& start, double steps, const Ground& ground);

/// Turns the eye where it is: the picture follows the cursor's way, a pixel being the angle that it has at the
/// picture's centre. Pitch stays within +-90 degrees.
View lookedAround(const View& start, geo::Vec2 drag_px, const Ground& ground);

/// Flies around the held point at constant distance, the point staying at its pixel: half a turn for a drag over the
/// picture's height; the picture follows the cursor. From level with the point to straight above it.
View orbited(const View& start, const Grip& grip, geo::Vec2 drag_px, const Ground& ground);

/// Turns north up, around the grip where there is one, else where the eye is.
View northUp(const View& start, const std::optional<Grip>& grip, const Ground& ground);

/// The same view with the eye raised to the clearance where it is lower. Call it whenever ground has arrived.
View cleared(const View& start, const Ground& ground);

}  // namespace tellurion::scene
