#include "scene/flight.h"

#include <algorithm>
#include <cmath>

#include "scene/navigation.h"

namespace tellurion::scene {
namespace {

using geo::Angle;
using geo::Vec3;

constexpr double kRho = 1.42;           // van Wijk and Nuij, section 6: what their users liked best
constexpr double kSecondsAUnit = 0.45;  // of the path's length; the paper's V is about 1
constexpr double kUnitsARadian = 2.5;   // around the body, which the paper's plane does not know
constexpr double kRadiansASecond = 1.2;
constexpr double kShortest_s = 0.3;
constexpr double kLongest_s = 10.0;
constexpr double kStill_m = 1e-6;    // what is less far
constexpr double kStill_rad = 1e-9;  // or turned less, has arrived
constexpr double kNearPole = 0.5;    // cos(60 degrees)

double shortWay(double radians) {
  return std::remainder(radians, 2.0 * geo::kPi);
}

/// No jerk at either end (Perlin's polynomial).
double easedShare(double share) {
  const double x = std::clamp(share, 0.0, 1.0);
  return x * x * x * (x * (6.0 * x - 15.0) + 10.0);
}

Vec3 turnedAbout(const Vec3& v, const Vec3& axis, double angle) {
  const double cosine = std::cos(angle);
  return v * cosine + geo::cross(axis, v) * std::sin(angle) + axis * (geo::dot(axis, v) * (1.0 - cosine));
}

double between(double a, double b, double share) {
  return a + (b - a) * share;
}

/// cos of the highest latitude on the way.
double nearestToPole(const Vec3& from, const Vec3& to, const Vec3& axis) {
  double level = std::min(std::hypot(from.x, from.y), std::hypot(to.x, to.y));
  // The circle's own highest places, where they lie between the two ends.
  const Vec3 top = Vec3(0.0, 0.0, 1.0) - axis * axis.z;
  if (!(geo::length(top) > 0.0)) return level;
  for (const double sign : {-1.0, 1.0}) {
    const Vec3 place = geo::normalize(top) * sign;
    const bool isOnTheWay =
        geo::dot(geo::cross(from, place), axis) >= 0.0 && geo::dot(geo::cross(place, to), axis) >= 0.0;
    if (isOnTheWay) level = std::min(level, std::hypot(place.x, place.y));
  }
  return level;
}

double overGround_m(const Pose& pose, double ground_m) {
  return std::max(pose.height_m - ground_m, kClearance_m);
}

}  // namespace

Flight::Flight(const View& from, const View& to, const Ground& ground)
    : ellipsoid_(ground.ellipsoid),
      from_(from),
      to_(to),
      fromPose_(poseOf(from, ground.ellipsoid)),
      toPose_(poseOf(to, ground.ellipsoid)),
      fromGround_m_(ground.heightOrZero_m(fromPose_.up)),
      toGround_m_(ground.heightOrZero_m(toPose_.up)) {
  to_.verticalFov = from.verticalFov;
  to_.viewport = from.viewport;
  const Vec3& a = fromPose_.up.n;
  const Vec3& b = toPose_.up.n;
  const Vec3 across = geo::cross(a, b);
  angle_ = geo::angleBetween(fromPose_.up, toPose_.up).radians();
  const bool isDefinite = geo::length(across) > 1e-12;
  axis_ = isDefinite ? geo::normalize(across) : geo::normalize(geo::cross(a, fromPose_.forward));
  keepsNorth_ = nearestToPole(a, b, axis_) > kNearPole;
  const Pose arriving = poseAt(1.0);  // turn_ is still 0
  turn_ = shortWay(headingOf(toPose_).radians() - headingOf(arriving).radians());

  way_m_ = angle_ * ellipsoid_.meanRadius_m();
  const double w0 = overGround_m(fromPose_, fromGround_m_);
  const double w1 = overGround_m(toPose_, toGround_m_);
  highest_m_ = std::max({w0, w1, (kHighest_radii - 1.0) * ellipsoid_.semiMajorAxis_m()});
  if (way_m_ > 1e-6 * std::min(w0, w1)) {
    // r(i) = ln(-b + sqrt(b^2 + 1)) = -asinh(b), without the cancellation.
    const double rho2u = kRho * kRho * way_m_;
    const double b0 = (w1 * w1 - w0 * w0 + rho2u * rho2u) / (2.0 * w0 * rho2u);
    const double b1 = (w1 * w1 - w0 * w0 - rho2u * rho2u) / (2.0 * w1 * rho2u);
    r0_ = -std::asinh(b0);
    length_ = (-std::asinh(b1) - r0_) / kRho;
  } else {
    length_ = std::abs(std::log(w1 / w0)) / kRho;
  }
  const double turned = std::max({std::abs(turn_), std::abs(toPose_.pitch.radians() - fromPose_.pitch.radians()),
                                  std::abs(shortWay(toPose_.roll.radians() - fromPose_.roll.radians()))});
  if (geo::length(to.eye - from.eye) < kStill_m && turned < kStill_rad) return;
  duration_s_ = std::clamp(std::max(costUpTo(1.0) * kSecondsAUnit, turned / kRadiansASecond), kShortest_s, kLongest_s);
}

Flight::Level Flight::levelAt(double share) const {
  const double w0 = overGround_m(fromPose_, fromGround_m_);
  const double w1 = overGround_m(toPose_, toGround_m_);
  if (!(way_m_ > 1e-6 * std::min(w0, w1))) return {.over_m = w0 * std::pow(w1 / w0, share), .share = share};
  const double r = kRho * length_ * share + r0_;
  const double over_m = w0 * std::cosh(r0_) / std::cosh(r);
  const double along_m = w0 / (kRho * kRho) * (std::cosh(r0_) * std::tanh(r) - std::sinh(r0_));
  return {.over_m = std::min(over_m, highest_m_), .share = std::clamp(along_m / way_m_, 0.0, 1.0)};
}

Pose Flight::poseAt(double share) const {
  const Level level = levelAt(share);
  Pose pose = fromPose_;
  pose.up.n = geo::normalize(turnedAbout(fromPose_.up.n, axis_, angle_ * level.share));
  pose.height_m = level.over_m + between(fromGround_m_, toGround_m_, level.share);
  pose.forward = turnedAbout(fromPose_.forward, axis_, angle_ * level.share);
  pose.forward = geo::normalize(pose.forward - pose.up.n * geo::dot(pose.forward, pose.up.n));
  if (keepsNorth_) pose = turnedBy(pose, headingOf(fromPose_) - headingOf(pose));
  pose = turnedBy(pose, Angle::radians(turn_ * share));
  pose.pitch = Angle::radians(between(fromPose_.pitch.radians(), toPose_.pitch.radians(), share));
  pose.roll = fromPose_.roll + Angle::radians(shortWay((toPose_.roll - fromPose_.roll).radians()) * share);
  return pose;
}

double Flight::costUpTo(double share) const {
  return length_ * share + kUnitsARadian * angle_ * levelAt(share).share;
}

double Flight::shareAt(double seconds) const {
  const double eased = easedShare(seconds / duration_s_);
  const double cost = costUpTo(1.0) * eased;
  if (!(costUpTo(1.0) > 0.0)) return eased;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (costUpTo(middle) < cost ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

View Flight::at(double seconds) const {
  if (!(seconds > 0.0)) return from_;
  if (seconds >= duration_s_) return to_;
  return viewOf(poseAt(shareAt(seconds)), ellipsoid_, from_);
}

}  // namespace tellurion::scene
