#pragma once

#include <functional>

#include "scene/picking.h"

// How far a pixel of a picture is off, in pixels. Plain arithmetic over rays: it knows neither tiles nor data.
namespace tellurion::truth {

/// Where a ray (unit direction) first meets a surface, in metres from its origin; NaN when it never does. Two ends
/// where the data leave open where the surface is; it is somewhere between them.
struct Seen {
  double nearest_m = 0.0;
  double farthest_m = 0.0;
};

/// Of a surface that is known.
inline Seen exactly(double distance_m) {
  return {.nearest_m = distance_m, .farthest_m = distance_m};
}

using SeenAlong = std::function<Seen(const geo::Ray&)>;

/// The smallest distance in pixels between what a pixel shows and the surface as it is seen from the eye: the surface
/// is looked for along rays around the pixel's centre, on rings a quarter of a pixel apart (a half from 3 pixels on),
/// and a way along a ray counts in widths of a pixel there.
///
/// Where neighbouring rays see the surface on both sides of what is drawn, it lies between them: at steep ground, and
/// at an outline. There the sky counts as infinitely far, so a missing peak is as many pixels off as the picture's
/// outline is. What is drawn through a hole of the surface, or before an obstacle that is not there, is off by the way
/// to the next ray that does not contradict it.
///
/// drawn_m: metres from the eye along the pixel's ray; NaN is sky. centre: the surface on that ray. Looks
/// no further than most_px, and is infinite beyond; ends as soon as the distance is known to be no more than enough_px,
/// and is then a bound of it that is no more either.
double missOf(const SeenAlong& surface, const scene::View& view, scene::PixelPosition pixel, double drawn_m,
              const Seen& centre, double most_px, double enough_px = 0.0);

}  // namespace tellurion::truth
