#include "scene/picking.h"

#include <algorithm>
#include <cmath>

namespace tellurion::scene {
namespace {

// The highest mountains of the bodies that we know reach 0.0065 of the radius (Olympus Mons, the Moon's far side).
constexpr double kHighestGround = 0.01;
constexpr double kSmallestStep_m = 1e-3;
constexpr int kMostSteps = 20000;
constexpr int kHalvings = 60;

geo::BodyPosition at(const geo::Ray& ray, double t) {
  return ray.origin + ray.direction * t;
}

// Above at `above`, not above at `below`.
double crossing(const geo::Ray& ray, const Ground& ground, double above, double below) {
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (above + below);
    (heightAboveGround_m(at(ray, middle), ground) > 0.0 ? above : below) = middle;
  }
  return below;
}

struct Stretch {
  double from = 0.0;
  double to = 0.0;
};

// The part of the ray inside the shell of possible ground; a ray that starts inside leaves it at the first meeting.
std::optional<Stretch> insideShell(const geo::Ray& ray, const geo::Ellipsoid& ellipsoid, double top_m) {
  const auto first = ellipsoid.intersect(ray, top_m);
  if (!first) return std::nullopt;
  if (ellipsoid.geodeticFromBody(ray.origin).height_m <= top_m) return Stretch{0.0, *first};
  const double inwards = *first + 1e-9 * ellipsoid.semiMajorAxis_m();
  const auto out = ellipsoid.intersect({at(ray, inwards), ray.direction}, top_m);
  return Stretch{*first, out ? inwards + *out : inwards};
}

}  // namespace

double heightAboveGround_m(const geo::BodyPosition& p, const Ground& ground) {
  return ground.ellipsoid.geodeticFromBody(p).height_m - ground.heightOrZero_m(ground.ellipsoid.directionFromBody(p));
}

PixelPosition centreOf(const Viewport& viewport) {
  return {0.5 * viewport.width, 0.5 * viewport.height};
}

geo::Vec3 viewDirectionThrough(const View& view, PixelPosition pixel) {
  const PixelPosition centre = centreOf(view.viewport);
  const Sides sides = view.sides();
  const double width = sides.width() / view.viewport.width;
  const double height = sides.height() / view.viewport.height;
  return geo::normalize(
      geo::Vec3(sides.middleX() + (pixel.x - centre.x) * width, sides.middleY() + (centre.y - pixel.y) * height, -1.0));
}

geo::Ray rayThrough(const View& view, PixelPosition pixel) {
  return {view.eye, viewDirectionThrough(view, pixel) * view.viewFromBody};  // v * M is transpose(M) * v
}

std::optional<PixelPosition> pixelOf(const View& view, const geo::BodyPosition& point) {
  const geo::Vec3 p_view = view.viewFromBody * (point - view.eye);
  if (!(p_view.z < 0.0)) return std::nullopt;
  const PixelPosition centre = centreOf(view.viewport);
  const Sides sides = view.sides();
  return PixelPosition{centre.x + (p_view.x / -p_view.z - sides.middleX()) * view.viewport.width / sides.width(),
                       centre.y - (p_view.y / -p_view.z - sides.middleY()) * view.viewport.height / sides.height()};
}

std::optional<geo::BodyPosition> groundAlong(const geo::Ray& ray, const Ground& ground, double pixelAngle) {
  const double top_m = kHighestGround * ground.ellipsoid.semiMajorAxis_m();
  const auto stretch = insideShell(ray, ground.ellipsoid, top_m);
  if (!stretch) return std::nullopt;
  double above = stretch->from;
  double clearance_m = heightAboveGround_m(at(ray, above), ground);
  for (int i = 0; i < kMostSteps && above < stretch->to; ++i) {
    if (!(clearance_m > 0.0)) return at(ray, above);
    const double next = above + std::max({0.5 * clearance_m, 0.5 * pixelAngle * above, kSmallestStep_m});
    clearance_m = heightAboveGround_m(at(ray, next), ground);
    if (!(clearance_m > 0.0)) return at(ray, crossing(ray, ground, above, next));
    above = next;
  }
  const auto onEllipsoid = ground.ellipsoid.intersect(ray);
  if (!onEllipsoid || ground.ellipsoid.geodeticFromBody(ray.origin).height_m < 0.0) return std::nullopt;
  return at(ray, *onEllipsoid);
}

std::optional<geo::BodyPosition> pointUnder(const View& view, PixelPosition pixel, const Ground& ground) {
  return groundAlong(rayThrough(view, pixel), ground, view.pixelAngle());
}

}  // namespace tellurion::scene
