#include "scene/walk.h"

#include <algorithm>
#include <cmath>

#include "scene/pose.h"

namespace tellurion::scene {
namespace {

using geo::Vec3;

constexpr double kStep_s = 1.0 / 120.0;
constexpr double kLongestStep_rad = 0.01;  // the radii of curvature change little on it
constexpr double kGravity_mps2 = 9.81;
constexpr double kSettling_per_s = 6.0;  // of the critically damped spring between eye and ground
constexpr double kAhead_s = 0.4;
constexpr int kLooksAhead = 16;
constexpr double kStands_m = 1e-3;

/// How the normal turns for a metre of way at this height: the ellipsoid's radii of curvature along the meridian and
/// across it (Snyder, Map Projections, USGS Professional Paper 1395, equations 4-18 and 4-20).
Vec3 turnPerMetre(const Pose& pose, const Vec3& way, const geo::Ellipsoid& ellipsoid) {
  const Vec3& n = pose.up.n;
  const double a = ellipsoid.semiMajorAxis_m(), f = ellipsoid.flattening();
  const double e2 = f * (2.0 - f);
  const double w2 = 1.0 - e2 * n.z * n.z;
  const double across_m = a / std::sqrt(w2);
  const double along_m = across_m * (1.0 - e2) / w2;
  const double level = std::hypot(n.x, n.y);
  const Vec3 east = level > 0.0 ? Vec3(-n.y / level, n.x / level, 0.0) : Vec3(0.0, 1.0, 0.0);
  const Vec3 north = geo::cross(n, east);
  return north * (geo::dot(way, north) / (along_m + pose.height_m)) +
         east * (geo::dot(way, east) / (across_m + pose.height_m));
}

/// Along the geodesic ahead, so many metres ahead and to the right, at the height of the pose.
Pose carriedAhead(Pose pose, double ahead_m, double right_m, const geo::Ellipsoid& ellipsoid) {
  const double way_m = std::hypot(ahead_m, right_m);
  if (!(way_m > 0.0)) return pose;
  const double radius_m = ellipsoid.semiMinorAxis_m() * (1.0 - ellipsoid.flattening()) + pose.height_m;
  const int steps = std::max(1, static_cast<int>(std::ceil(way_m / (kLongestStep_rad * radius_m))));
  for (int i = 0; i < steps; ++i) {
    const Vec3 way = (pose.forward * ahead_m + pose.right() * right_m) / way_m;
    const Vec3 turn = turnPerMetre(pose, way, ellipsoid) * (way_m / steps);
    const double angle = geo::length(turn);
    const geo::Direction up{geo::normalize(pose.up.n * std::cos(angle) + turn * (std::sin(angle) / angle))};
    const Vec3 forward = geo::rotatedBetween(pose.forward, pose.up.n, up.n);
    pose.forward = geo::normalize(forward - up.n * geo::dot(forward, up.n));
    pose.up = up;
  }
  return pose;
}

Stride shortened(Stride stride, bool heedsUp) {
  if (!heedsUp) stride.up = 0.0;
  const double length = std::hypot(stride.ahead, stride.right, stride.up);
  if (length <= 1.0) return stride;
  return {stride.ahead / length, stride.right / length, stride.up / length};
}

int stepsIn(double seconds) {
  return std::max(1, static_cast<int>(std::ceil(seconds / kStep_s - 1e-9)));
}

/// The least vertical speed at which the eye is over all ground that it reaches within kAhead_s.
double neededClimb_mps(const Pose& pose, const Stride& stride, double speed_mps, const Ground& ground) {
  double needed = -1e9;
  for (int i = 1; i <= kLooksAhead; ++i) {
    const double t = kAhead_s * i / kLooksAhead;
    const double way_m = speed_mps * t;
    const Pose there = carriedAhead(pose, stride.ahead * way_m, stride.right * way_m, ground.ellipsoid);
    needed = std::max(needed, (leastHeight_m(there.up, ground) - pose.height_m) / t);
  }
  return needed;
}

/// Sinks like a stone at first, and then settles like a critically damped spring; rises as fast as it must.
double nextClimb_mps(double climb_mps, double over_m, double needed_mps, double seconds) {
  if (needed_mps >= 0.0) return needed_mps;
  // What it was lifted with is not a throw.
  if (climb_mps > 0.0) climb_mps = std::max(0.0, climb_mps - std::max(kGravity_mps2, 10.0 * climb_mps) * seconds);
  const double k = kSettling_per_s;
  const double pull_mps2 = -k * k * over_m - 2.0 * k * climb_mps;
  return climb_mps + std::max(pull_mps2, -kGravity_mps2) * seconds;
}

struct Footing {
  Pose pose;
  double climb_mps = 0.0;
};

Footing stepped(Footing now, const Stride& stride, double speed_mps, double seconds, const Ground& ground) {
  const bool walks = !stride.rests() && speed_mps > 0.0;
  const double over_m = now.pose.height_m - leastHeight_m(now.pose.up, ground);
  const double needed = walks ? neededClimb_mps(now.pose, stride, speed_mps, ground) : -1e9;
  now.climb_mps = nextClimb_mps(now.climb_mps, std::max(over_m, 0.0), needed, seconds);
  const double way_m = speed_mps * seconds;
  now.pose = carriedAhead(now.pose, stride.ahead * way_m, stride.right * way_m, ground.ellipsoid);
  now.pose.height_m += now.climb_mps * seconds;
  const double least_m = leastHeight_m(now.pose.up, ground);
  const bool settles = !walks && now.climb_mps <= 0.0 && now.climb_mps > -kStands_m * kSettling_per_s;
  if (now.pose.height_m <= least_m + (settles ? kStands_m : 0.0)) {
    now.pose.height_m = least_m;
    now.climb_mps = std::max(now.climb_mps, 0.0);
    if (!walks) now.climb_mps = 0.0;
  }
  return now;
}

}  // namespace

Walker walked(const Walker& start, const Stride& stride, double speed_mps, double seconds, const Ground& ground) {
  const Stride level = shortened(stride, false);
  if (!(seconds > 0.0) || (level.rests() && stands(start, ground)))
    return {cleared(start.view, ground), start.climb_mps};
  const int steps = stepsIn(seconds);
  Footing now{poseOf(start.view, ground.ellipsoid), start.climb_mps};
  for (int i = 0; i < steps; ++i)
    now = stepped(now, level, speed_mps, seconds / steps, ground);
  return {viewOf(now.pose, ground.ellipsoid, start.view), now.climb_mps};
}

bool stands(const Walker& walker, const Ground& ground) {
  return walker.climb_mps == 0.0 && std::abs(heightAboveGround_m(walker.view.eye, ground) - kClearance_m) <= kStands_m;
}

View flown(const View& start, const Stride& stride, double rate, double seconds, const Ground& ground) {
  const Stride wished = shortened(stride, true);
  if (!(seconds > 0.0) || wished.rests()) return cleared(start, ground);
  const int steps = stepsIn(seconds);
  Pose pose = poseOf(start, ground.ellipsoid);
  const double sine = std::sin(pose.pitch.radians()), cosine = std::cos(pose.pitch.radians());
  const double way_per_height = rate * seconds / steps;
  const double rise = wished.ahead * sine + wished.up;
  double least_m = leastHeight_m(pose.up, ground);
  for (int i = 0; i < steps; ++i) {
    const double over_m = pose.height_m - least_m + kClearance_m;
    // On a straight way through the step the height changes too: that of its middle counts.
    const double middle_m = std::max(over_m * (1.0 + 0.5 * way_per_height * rise), kClearance_m);
    const double way_m = way_per_height * middle_m;
    pose = carriedAhead(pose, wished.ahead * cosine * way_m, wished.right * way_m, ground.ellipsoid);
    least_m = leastHeight_m(pose.up, ground);
    const double greatest_m = std::max({pose.height_m, greatestHeight_m(ground), least_m});
    pose.height_m = std::clamp(pose.height_m + rise * way_m, least_m, greatest_m);
  }
  return viewOf(pose, ground.ellipsoid, start);
}

}  // namespace tellurion::scene
