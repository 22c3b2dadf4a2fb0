#include "scene/navigation.h"

#include <algorithm>
#include <cmath>

#include "scene/pose.h"

namespace tellurion::scene {
namespace {

using geo::Angle;
using geo::BodyPosition;
using geo::Vec3;

Pose clearedPose(Pose pose, const Ground& ground) {
  pose.height_m = std::max(pose.height_m, leastHeight_m(pose.up, ground));
  return pose;
}

// ---- The eye from which a held point is seen at a pixel: Newton's method over the eye's three coordinates.

struct EyeProblem {
  const View& like;
  const Pose& carried;  ///< heading and pitch are this pose's, taken along
  const Ground& ground;
  BodyPosition point;
  Vec3 seen_view;   ///< where the point shall be seen
  double scale_m;   ///< a length of the problem's size
  bool keepHeight;  ///< the third wish: this height above the ellipsoid, else this distance from the point
  double wished_m;
};

struct Eye {
  geo::Direction up;
  double height_m;
};

// Two angles between where the point is seen and where it shall be, and the relative error of height or distance.
Vec3 errorAt(const EyeProblem& problem, const Eye& eye) {
  const View view = viewOf(carriedTo(problem.carried, eye.up, eye.height_m), problem.ground.ellipsoid, problem.like);
  const Vec3 p_view = view.viewFromBody * (problem.point - view.eye);
  const double distance = geo::length(p_view);
  if (!(geo::dot(p_view, problem.seen_view) > 0.0)) return Vec3(10.0);  // behind the eye: worse than any angle
  const Vec3 sideways = geo::normalize(geo::cross(problem.seen_view, Vec3(0.0, 1.0, 0.0)));
  const Vec3 upwards = geo::cross(sideways, problem.seen_view);
  const double third = (problem.keepHeight ? eye.height_m : distance) - problem.wished_m;
  return {geo::dot(p_view, sideways) / distance, geo::dot(p_view, upwards) / distance, third / problem.scale_m};
}

Eye moved(const Eye& eye, const Vec3& step, const EyeProblem& problem) {
  const Vec3 axis = std::abs(eye.up.n.z) < 0.7 ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
  const Vec3 a = geo::normalize(geo::cross(axis, eye.up.n));
  const Vec3 b = geo::cross(eye.up.n, a);
  const double perMetre = 1.0 / problem.ground.ellipsoid.semiMajorAxis_m();
  const Vec3 tangent = (a * step.x + b * step.y) * (problem.scale_m * perMetre);
  return {{geo::normalize(eye.up.n + tangent)}, eye.height_m + step.z * problem.scale_m};
}

geo::Mat3 slopesAt(const EyeProblem& problem, const Eye& eye, const Vec3& error) {
  constexpr double kStep = 1e-5;
  geo::Mat3 slopes(0.0);
  for (int i = 0; i < 3; ++i) {
    Vec3 step(0.0);
    step[i] = kStep;
    slopes[i] = (errorAt(problem, moved(eye, step, problem)) - error) / kStep;
  }
  return slopes;
}

// Nothing where no such eye is found near the first guess.
std::optional<Pose> solved(const EyeProblem& problem, Eye eye) {
  const double enough = std::max(1e-5 * problem.like.pixelAngle(), 1e-9);
  Vec3 error = errorAt(problem, eye);
  for (int i = 0; i < 50; ++i) {
    if (geo::length(error) < enough) return carriedTo(problem.carried, eye.up, eye.height_m);
    const geo::Mat3 slopes = slopesAt(problem, eye, error);
    if (!(std::abs(glm::determinant(slopes)) > 1e-12)) return std::nullopt;
    const Vec3 step = -(glm::inverse(slopes) * error);
    double share = 1.0;
    for (; share > 1e-3; share *= 0.5) {
      const Eye next = moved(eye, step * share, problem);
      const Vec3 nextError = errorAt(problem, next);
      if (!(geo::length(nextError) < geo::length(error))) continue;
      eye = next;
      error = nextError;
      break;
    }
    if (share <= 1e-3) return std::nullopt;
  }
  return std::nullopt;
}

// ---- Panning

// Where the cursor's ray meets the held point's height, if the point may be brought there.
class PanShell {
 public:
  PanShell(const View& start, const Grip& grip, const Ground& ground)
      : view_(start), ellipsoid_(ground.ellipsoid), height_m_(ellipsoid_.geodeticFromBody(grip.point).height_m) {
    const Vec3 toPoint = grip.point - start.eye;
    furthest_m_ = 30.0 * geo::length(toPoint);
    incidence_ = geo::dot(geo::normalize(toPoint), ellipsoid_.directionFromBody(grip.point).n);
  }

  std::optional<BodyPosition> under(PixelPosition pixel) const {
    const geo::Ray ray = rayThrough(view_, pixel);
    const auto t = ellipsoid_.intersect(ray, height_m_);
    if (!t || *t > furthest_m_) return std::nullopt;
    const BodyPosition p = ray.origin + ray.direction * *t;
    const double incidence = geo::dot(ray.direction, ellipsoid_.directionFromBody(p).n);
    const bool steepEnough = std::abs(incidence) >= std::min(0.05, 0.5 * std::abs(incidence_));
    if (!steepEnough || std::signbit(incidence) != std::signbit(incidence_)) return std::nullopt;
    return p;
  }

 private:
  const View& view_;
  const geo::Ellipsoid& ellipsoid_;
  double height_m_;
  double furthest_m_ = 0.0;
  double incidence_ = 0.0;
};

PixelPosition between(PixelPosition a, PixelPosition b, double share) {
  return {a.x + (b.x - a.x) * share, a.y + (b.y - a.y) * share};
}

// The cursor, or the last place on the straight way to it where the point can be brought.
PixelPosition lastReachable(const PanShell& shell, PixelPosition from, PixelPosition to) {
  if (shell.under(to)) return to;
  double good = 0.0, bad = 1.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (good + bad);
    (shell.under(between(from, to, middle)) ? good : bad) = middle;
  }
  return between(from, to, good);
}

// ---- Zooming

// Turned so that the point is at its pixel; straight down where that would need to lean back over the nadir.
Pose turnedTowards(const Pose& pose, const Grip& grip, const View& like, const Ground& ground) {
  const BodyPosition eye = ground.ellipsoid.bodyFromDirection(pose.up, pose.height_m);
  const Vec3 target = geo::normalize(grip.point - eye);
  if (const auto turned = facing(pose, target, viewDirectionThrough(like, grip.pixel))) return *turned;
  Pose down = pose;
  down.pitch = Angle::degrees(-90);
  return down;
}

double wishedDistance_m(double distance_m, double steps, const Ground& ground) {
  const double wished = distance_m * std::pow(kZoomStep, steps);
  const double furthest = (kHighest_radii - 1.0) * ground.ellipsoid.semiMajorAxis_m();
  if (steps > 0.0) return std::max(wished, std::min(distance_m, 2.0 * kClearance_m));
  return std::min(wished, std::max(distance_m, furthest));
}

bool seesFront(const BodyPosition& eye, const BodyPosition& point, const Ground& ground) {
  return geo::dot(eye - point, ground.ellipsoid.directionFromBody(point).n) > 0.0;
}

// Pitch kept. Nothing where that cannot be, or would throw the eye far from where it is.
std::optional<View> zoomedLevel(const View& start, const Grip& grip, double distance_m, double wished_m,
                                const Ground& ground) {
  const Pose pose = poseOf(start, ground.ellipsoid);
  const BodyPosition guess = grip.point + (start.eye - grip.point) * (wished_m / distance_m);
  const Eye eye{ground.ellipsoid.directionFromBody(guess), ground.ellipsoid.geodeticFromBody(guess).height_m};
  const Vec3 seen = viewDirectionThrough(start, grip.pixel);
  const auto found = solved({start, pose, ground, grip.point, seen, wished_m, false, wished_m}, eye);
  if (!found || found->height_m < leastHeight_m(found->up, ground) || found->height_m > greatestHeight_m(ground))
    return std::nullopt;
  const View view = viewOf(*found, ground.ellipsoid, start);
  if (geo::length(view.eye - start.eye) > 4.0 * std::abs(wished_m - distance_m)) return std::nullopt;
  if (seesFront(start.eye, grip.point, ground) && !seesFront(view.eye, grip.point, ground)) return std::nullopt;
  return view;
}

// ---- Orbiting

class OrbitPath {
 public:
  OrbitPath(const View& start, const Grip& grip, const Ground& ground)
      : start_(start),
        grip_(grip),
        ground_(ground),
        pose_(poseOf(start, ground.ellipsoid)),
        up_(ground.ellipsoid.directionFromBody(grip.point).n) {
    const Vec3 offset = start.eye - grip.point;
    distance_m_ = geo::length(offset);
    const Vec3 level = offset - up_ * geo::dot(offset, up_);
    const double levelLength = geo::length(level);
    const Vec3 behind = -pose_.forward;
    outwards_ =
        levelLength > 1e-7 * distance_m_ ? level / levelLength : geo::normalize(behind - up_ * geo::dot(behind, up_));
    elevation_ = std::atan2(geo::dot(offset, up_), levelLength);
  }

  /// The view after turning clockwise around the point and rising, both in radians. Where the eye cannot be so high or
  /// so low, at the nearest elevation that it can have.
  View at(double clockwise, double rise) const {
    const double lowest = std::min(elevation_, 0.0);
    const double wished = std::clamp(elevation_ + rise, lowest, 0.5 * geo::kPi);
    if (const auto view = exactly(clockwise, wished)) return *view;
    const auto good = nearestGood(clockwise, wished, lowest);
    return good ? *good : start_;
  }

 private:
  std::optional<View> nearestGood(double clockwise, double wished, double lowest) const {
    constexpr double kStep = geo::kPi / 360.0;
    for (int i = 1; i <= 360; ++i) {
      for (const double sign : {-1.0, 1.0}) {
        const double good = wished + sign * i * kStep;
        if (good < lowest || good > 0.5 * geo::kPi || !exactly(clockwise, good)) continue;
        return halved(clockwise, good, wished);
      }
    }
    return std::nullopt;
  }

  std::optional<View> halved(double clockwise, double good, double bad) const {
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (good + bad);
      (exactly(clockwise, middle) ? good : bad) = middle;
    }
    return exactly(clockwise, good);
  }

  std::optional<View> exactly(double clockwise, double elevation) const {
    const geo::Ellipsoid& ellipsoid = ground_.ellipsoid;
    const Vec3 outwards = turned(outwards_, clockwise);
    const BodyPosition eye = grip_.point + (outwards * std::cos(elevation) + up_ * std::sin(elevation)) * distance_m_;
    Pose pose = pose_;
    pose.up = ellipsoid.directionFromBody(eye);
    pose.height_m = ellipsoid.geodeticFromBody(eye).height_m;
    if (pose.height_m < std::min(leastHeight_m(pose.up, ground_), pose_.height_m)) return std::nullopt;
    const Vec3 forward = turned(pose_.forward, clockwise);
    pose.forward = geo::normalize(forward - pose.up.n * geo::dot(forward, pose.up.n));
    pose.pitch = pose_.pitch - Angle::radians(elevation - elevation_);
    const auto faced = facing(pose, geo::normalize(grip_.point - eye), viewDirectionThrough(start_, grip_.pixel));
    if (!faced) return std::nullopt;
    return viewOf(*faced, ellipsoid, start_);
  }

  Vec3 turned(const Vec3& v, double clockwise) const {
    const Vec3 along = up_ * geo::dot(v, up_);
    return along + (v - along) * std::cos(clockwise) + geo::cross(v, up_) * std::sin(clockwise);
  }

  const View& start_;
  const Grip& grip_;
  const Ground& ground_;
  Pose pose_;
  Vec3 up_;
  Vec3 outwards_{0.0};
  double distance_m_ = 0.0;
  double elevation_ = 0.0;
};

}  // namespace

double leastHeight_m(const geo::Direction& place, const Ground& ground) {
  return ground.heightOrZero_m(place) + kClearance_m;
}

double greatestHeight_m(const Ground& ground) {
  return kHighest_radii * ground.ellipsoid.semiMajorAxis_m();
}

std::optional<Grip> gripAt(const View& view, PixelPosition pixel, const Ground& ground) {
  const auto point = pointUnder(view, pixel, ground);
  if (!point) return std::nullopt;
  return Grip{pixel, *point};
}

View panned(const View& start, const Grip& grip, PixelPosition cursor, const Ground& ground) {
  const PanShell shell(start, grip, ground);
  const PixelPosition reachable = lastReachable(shell, grip.pixel, cursor);
  const auto under = shell.under(reachable);
  if (!under) return cleared(start, ground);
  const Pose pose = poseOf(start, ground.ellipsoid);
  Pose now = pose;
  now.up.n = geo::normalize(geo::rotatedBetween(pose.up.n, geo::normalize(under->m), geo::normalize(grip.point.m)));
  const double distance_m = geo::length(grip.point - start.eye);
  const Vec3 seen = viewDirectionThrough(start, reachable);
  for (int i = 0; i < 8; ++i) {  // the ground may push the eye up on the way
    const auto found =
        solved({start, pose, ground, grip.point, seen, distance_m, true, now.height_m}, {now.up, now.height_m});
    now = found ? *found : carriedTo(pose, now.up, now.height_m);
    const Pose above = clearedPose(now, ground);
    if (!(above.height_m > now.height_m)) break;
    now = above;
  }
  return viewOf(clearedPose(now, ground), ground.ellipsoid, start);
}

View zoomed(const View& start, const Grip& grip, double steps, const Ground& ground) {
  const double distance_m = geo::length(grip.point - start.eye);
  const double wished_m = wishedDistance_m(distance_m, steps, ground);
  if (wished_m == distance_m) return cleared(start, ground);
  if (const auto view = zoomedLevel(start, grip, distance_m, wished_m, ground)) return *view;
  const geo::Ellipsoid& ellipsoid = ground.ellipsoid;
  Pose pose = poseOf(start, ellipsoid);
  if (wished_m < distance_m) {
    const BodyPosition eye = grip.point + (start.eye - grip.point) * (wished_m / distance_m);
    pose = carriedTo(pose, ellipsoid.directionFromBody(eye), ellipsoid.geodeticFromBody(eye).height_m);
  } else {
    const double higher = pose.height_m + wished_m - distance_m;
    pose.height_m = std::min(higher, std::max(pose.height_m, greatestHeight_m(ground)));
  }
  return viewOf(turnedTowards(clearedPose(pose, ground), grip, start, ground), ellipsoid, start);
}

View climbed(const View& start, double steps, const Ground& ground) {
  Pose pose = poseOf(start, ground.ellipsoid);
  const double base_m = ground.heightOrZero_m(pose.up);
  const double height_m = base_m + (pose.height_m - base_m) * std::pow(kZoomStep, steps);
  pose.height_m = std::min(height_m, std::max(pose.height_m, greatestHeight_m(ground)));
  return viewOf(clearedPose(pose, ground), ground.ellipsoid, start);
}

View lookedAround(const View& start, geo::Vec2 drag_px, const Ground& ground) {
  const double perPixel = start.pixelAngle();
  Pose pose = turnedBy(poseOf(start, ground.ellipsoid), Angle::radians(-drag_px.x * perPixel));
  const Angle pitch = pose.pitch + Angle::radians(drag_px.y * perPixel);
  pose.pitch = std::clamp(pitch, Angle::degrees(-90), Angle::degrees(90));
  return viewOf(clearedPose(pose, ground), ground.ellipsoid, start);
}

View orbited(const View& start, const Grip& grip, geo::Vec2 drag_px, const Ground& ground) {
  const double perPixel = geo::kPi / start.viewport.height;
  const OrbitPath path(start, grip, ground);
  return cleared(path.at(drag_px.x * perPixel, drag_px.y * perPixel), ground);
}

View northUp(const View& start, const std::optional<Grip>& grip, const Ground& ground) {
  constexpr double kEnough = 1e-9;
  View view = start;
  for (int i = 0; grip && i < 20; ++i) {
    const double heading = headingOf(poseOf(view, ground.ellipsoid)).radians();
    if (std::abs(heading) < kEnough) return cleared(view, ground);
    const Grip held = *grip;
    view = OrbitPath(view, held, ground).at(-heading, 0.0);
  }
  const Pose pose = poseOf(start, ground.ellipsoid);
  return viewOf(clearedPose(turnedBy(pose, -headingOf(pose)), ground), ground.ellipsoid, start);
}

View cleared(const View& start, const Ground& ground) {
  const geo::Direction up = ground.ellipsoid.directionFromBody(start.eye);
  const double short_m = leastHeight_m(up, ground) - ground.ellipsoid.geodeticFromBody(start.eye).height_m;
  if (!(short_m > 0.0)) return start;
  View view = start;
  view.eye = start.eye + up.n * short_m;
  return view;
}

}  // namespace tellurion::scene
