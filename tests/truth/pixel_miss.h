#pragma once

#include <functional>

#include "scene/picking.h"

// How far a pixel of a picture is off, in pixels. Plain arithmetic over rays: it knows neither tiles nor data.
namespace tellurion::truth {

/// Metres from a ray's origin to where it (unit direction) first meets a surface; NaN when it never does.
using DistanceAlong = std::function<double(const geo::Ray&)>;

/// The smallest distance in pixels between what a pixel shows and the surface as it is seen from the eye: the surface
/// is looked for along rays around the pixel's centre, on rings a quarter of a pixel apart (a half from 3 pixels on),
/// and a way along a ray counts in widths of a pixel there.
///
/// Where neighbouring rays see the surface on both sides of what is drawn, it lies between them: at steep ground, and
/// at an outline. There the sky counts as infinitely far, so a missing peak is as many pixels off as the picture's
/// outline is. What is drawn through a hole of the surface, or before an obstacle that is not there, is off by the way
/// to the next ray that does not contradict it.
///
/// drawn_m: metres from the eye along the pixel's ray; NaN is sky. centre_m: the surface on that ray, likewise. Looks
/// no further than most_px, and is infinite beyond; ends as soon as the distance is known to be no more than enough_px,
/// and is then a bound of it that is no more either.
double missOf(const DistanceAlong& surface, const scene::View& view, scene::PixelPosition pixel, double drawn_m,
              double centre_m, double most_px, double enough_px = 0.0);

}  // namespace tellurion::truth
