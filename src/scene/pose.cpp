#include "scene/pose.h"

#include <algorithm>
#include <cmath>

namespace tellurion::scene {
namespace {

using geo::Angle;
using geo::Vec3;

Vec3 levelled(const Vec3& v, const Vec3& up) {
  return geo::normalize(v - up * geo::dot(v, up));
}

double smoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// 1 where a heading means something, 0 within 10 degrees of a pole. cos(latitude) is the length of the horizontal part.
double trustInHeading(const geo::Direction& up) {
  return smoothStep(0.17364817766693033, 0.3420201433256687, std::hypot(up.n.x, up.n.y));
}

double wrappedRadians(double radians) {
  return std::remainder(radians, 2.0 * geo::kPi);
}

// Pitches p with R sin(p + phase) = height, within a right angle of the horizon; the one nearer to `wished`.
std::optional<double> pitchFor(double sine, double phase, double wished) {
  std::optional<double> best;
  for (const double angle : {std::asin(sine), geo::kPi - std::asin(sine)}) {
    const double p = wrappedRadians(angle - phase);
    if (std::abs(p) > 0.5 * geo::kPi + 1e-9) continue;
    if (!best || std::abs(p - wished) < std::abs(*best - wished)) best = std::clamp(p, -0.5 * geo::kPi, 0.5 * geo::kPi);
  }
  return best;
}

}  // namespace

Pose poseOf(const View& view, const geo::Ellipsoid& ellipsoid) {
  const geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  const Vec3 look = -bodyFromView[2];
  const geo::Direction up = ellipsoid.directionFromBody(view.eye);
  const Vec3 sideways = geo::cross(look, up.n);
  const double level = geo::length(sideways);
  const Vec3 right = level > 1e-9 ? sideways / level : levelled(bodyFromView[0], up.n);
  Pose pose;
  pose.up = up;
  pose.height_m = ellipsoid.geodeticFromBody(view.eye).height_m;
  pose.forward = geo::cross(up.n, right);
  pose.pitch = Angle::radians(std::atan2(geo::dot(look, up.n), geo::dot(look, pose.forward)));
  pose.pitch = std::clamp(pose.pitch, Angle::degrees(-90), Angle::degrees(90));
  const Vec3 viewUp = geo::cross(right, look);
  pose.roll = Angle::radians(std::atan2(-geo::dot(bodyFromView[0], viewUp), geo::dot(bodyFromView[0], right)));
  return pose;
}

View viewOf(const Pose& pose, const geo::Ellipsoid& ellipsoid, const View& like) {
  const double cosPitch = std::cos(pose.pitch.radians()), sinPitch = std::sin(pose.pitch.radians());
  const double cosRoll = std::cos(pose.roll.radians()), sinRoll = std::sin(pose.roll.radians());
  const Vec3 look = pose.forward * cosPitch + pose.up.n * sinPitch;
  const Vec3 levelUp = pose.up.n * cosPitch - pose.forward * sinPitch;
  const Vec3 right = pose.right() * cosRoll - levelUp * sinRoll;
  const Vec3 upwards = levelUp * cosRoll + pose.right() * sinRoll;
  View view = like;
  view.eye = ellipsoid.bodyFromDirection(pose.up, pose.height_m);
  view.viewFromBody = glm::transpose(geo::Mat3(right, upwards, -look));
  return view;
}

Angle headingOf(const Pose& pose) {
  const Vec3& n = pose.up.n;
  const double level = std::hypot(n.x, n.y);
  const Vec3 east = level > 0.0 ? Vec3(-n.y / level, n.x / level, 0.0) : Vec3(0.0, 1.0, 0.0);
  const Vec3 north = geo::cross(n, east);
  return Angle::radians(std::atan2(geo::dot(pose.forward, east), geo::dot(pose.forward, north)));
}

Pose turnedBy(const Pose& pose, Angle clockwise) {
  Pose turned = pose;
  turned.forward =
      levelled(pose.forward * std::cos(clockwise.radians()) + pose.right() * std::sin(clockwise.radians()), pose.up.n);
  return turned;
}

Pose carriedTo(const Pose& pose, const geo::Direction& up, double height_m) {
  Pose carried = pose;
  carried.up = up;
  carried.height_m = height_m;
  carried.forward = levelled(geo::rotatedBetween(pose.forward, pose.up.n, up.n), up.n);
  const double turn = wrappedRadians(headingOf(pose).radians() - headingOf(carried).radians());
  const double trust =
      trustInHeading(pose.up) * trustInHeading(up) * (1.0 - smoothStep(0.5 * geo::kPi, 0.9 * geo::kPi, std::abs(turn)));
  return turnedBy(carried, Angle::radians(turn * trust));
}

std::optional<Pose> facing(const Pose& pose, const Vec3& target_body, const Vec3& seen_view) {
  const double cosRoll = std::cos(pose.roll.radians()), sinRoll = std::sin(pose.roll.radians());
  const Vec3 seen(seen_view.x * cosRoll + seen_view.y * sinRoll, seen_view.y * cosRoll - seen_view.x * sinRoll,
                  seen_view.z);
  const double sine = geo::dot(target_body, pose.up.n) / std::hypot(seen.y, seen.z);
  if (!(std::abs(sine) <= 1.0 + 1e-12)) return std::nullopt;
  const auto pitch = pitchFor(std::clamp(sine, -1.0, 1.0), std::atan2(seen.y, -seen.z), pose.pitch.radians());
  if (!pitch) return std::nullopt;
  const double ahead = -seen.z * std::cos(*pitch) - seen.y * std::sin(*pitch);
  const double wished = std::atan2(geo::dot(target_body, pose.right()), geo::dot(target_body, pose.forward));
  Pose turned = turnedBy(pose, Angle::radians(wished - std::atan2(seen.x, ahead)));
  turned.pitch = Angle::radians(*pitch);
  return turned;
}

}  // namespace tellurion::scene
