#pragma once

#include "scene/camera.h"

namespace tellurion::scene {

/// The views around one that a cut is to be right for as well, of the same sides, viewport and size of a pixel; their
/// eyes lie in a ball of the body frame. None by default.
struct Leeway {
  double move_m = 0.0;  ///< how far the eye may be from that view's
  double turn = 0.0;    ///< how far the picture may reach beyond its sides, a share of half of it
};

/// Whether the view is one of those around `middle`. Exact: a picture whose corners lie within the sides does.
bool isWithin(const View& view, const View& middle, const Leeway& leeway);

/// What lets an eye that goes on as it went from `before` to `now` do so for several frames; none for one that rests,
/// and for one that is so fast that it would be out with the next. Bounded by small shares of the distance to the
/// nearest ground and of the picture, so that the cut gets only little larger for it.
Leeway leewayFor(const View& before, const View& now, double nearest_m);

}  // namespace tellurion::scene
