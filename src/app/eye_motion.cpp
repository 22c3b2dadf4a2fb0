#include "app/eye_motion.h"

#include <algorithm>
#include <utility>

#include "scene/flight.h"

namespace tellurion::app {
namespace {

constexpr double kZoom_s = 0.2;

/// Fast at once, and slower towards the end: an answer to a hand.
double easedOut(double seconds) {
  const double left = 1.0 - std::clamp(seconds / kZoom_s, 0.0, 1.0);
  return 1.0 - left * left * left;
}

}  // namespace

double EyeMotion::stepsLeft(double now_s) const {
  return zoomSteps * (1.0 - easedOut(now_s - begin_s));
}

EyeMotion flightTo(const scene::View& from, const scene::View& to, const scene::Ground& ground, double now_s) {
  const scene::Flight flight(from, to, ground);
  return {.begin_s = now_s,
          .duration_s = flight.duration_s(),
          .viewAt = [flight](double seconds, const scene::Ground&) { return flight.at(seconds); }};
}

EyeMotion easedZoom(const scene::View& from, const std::optional<scene::Grip>& grip, double steps, double now_s) {
  return {.begin_s = now_s,
          .duration_s = kZoom_s,
          .viewAt =
              [=](double seconds, const scene::Ground& ground) {
                const double done = steps * easedOut(seconds);
                return grip ? scene::zoomed(from, *grip, done, ground) : scene::climbed(from, done, ground);
              },
          .zoomSteps = steps};
}

EyeMotion alongPath(scene::CameraPath path, const scene::View& like, double now_s) {
  const double duration_s = path.duration().count();
  return {.begin_s = now_s,
          .duration_s = duration_s,
          .viewAt = [path = std::move(path), like](double seconds, const scene::Ground& ground) {
            const scene::Camera camera = path.at(path.begin() + scene::CameraPath::Seconds(seconds));
            return scene::viewOf(camera, ground.ellipsoid, like.verticalFov, like.viewport);
          }};
}

}  // namespace tellurion::app
