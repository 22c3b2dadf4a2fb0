#include "truth/pixel_miss.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::truth {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double skyIsFar(double distance_m) {
  return std::isnan(distance_m) ? kInfinity : distance_m;
}

}  // namespace

double missOf(const SeenAlong& surface, const scene::View& view, scene::PixelPosition pixel, double drawn_m,
              const Seen& centre, double most_px, double enough_px) {
  const double drawn = skyIsFar(drawn_m);
  const double width_m = drawn * view.pixelAngle();
  // The nearest rays on which the surface is not beyond what is drawn, and not before it.
  double notBeyond = kInfinity;
  double notBefore = kInfinity;
  const auto offTo = [&](double seen, double aside_px) {
    const double along_px = seen == drawn ? 0.0 : std::abs(seen - drawn) / width_m;  // NaN from the sky to the ground
    return std::isnan(along_px) ? kInfinity : std::hypot(aside_px, along_px);
  };
  const auto look = [&](const Seen& seen, double aside_px) {
    const double nearest = skyIsFar(seen.nearest_m);
    const double farthest = skyIsFar(seen.farthest_m);
    notBeyond = std::min(notBeyond, nearest <= drawn ? aside_px : offTo(nearest, aside_px));
    notBefore = std::min(notBefore, farthest >= drawn ? aside_px : offTo(farthest, aside_px));
  };
  look(centre, 0.0);
  if (std::max(notBeyond, notBefore) <= enough_px) return std::max(notBeyond, notBefore);
  for (double aside = 0.25; aside <= std::min(most_px, std::max(notBeyond, notBefore));
       aside += aside < 3 ? 0.25 : 0.5) {
    const int rays = aside <= 0.5 ? 8 : aside <= 1.5 ? 16 : 32;
    for (int i = 0; i < rays; ++i) {
      const double angle = 2.0 * geo::kPi * i / rays;
      const scene::PixelPosition place{pixel.x + aside * std::cos(angle), pixel.y + aside * std::sin(angle)};
      look(surface(scene::rayThrough(view, place)), aside);
      if (std::max(notBeyond, notBefore) <= enough_px) return std::max(notBeyond, notBefore);
    }
  }
  const double miss = std::max(notBeyond, notBefore);
  return miss <= most_px ? miss : kInfinity;
}

}  // namespace tellurion::truth
