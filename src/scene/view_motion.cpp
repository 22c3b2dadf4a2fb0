#include "scene/view_motion.h"

#include <algorithm>
#include <cmath>

namespace tellurion::scene {
namespace {

constexpr double kSpacing_s = 0.1;    ///< between the moments that are kept
constexpr double kShortest_s = 0.03;  ///< over less no speed is told
constexpr double kPause_s = 1.0;
constexpr double kLeap = 0.5;       ///< of the eye's height, between two frames
constexpr double kLeapAngle = 0.7;  ///< radians, likewise
constexpr double kRest = 0.02;      ///< of the eye's height, or radians: not worth looking ahead
constexpr double kFarthest = 4.0;   ///< heights that are looked ahead
constexpr double kMostTurn = 1.0;   ///< radians, likewise
constexpr double kMostClimb = 4.0;  ///< factor, likewise
constexpr double kLeastHeight_m = 10.0;

double heightOf(const geo::Ellipsoid& ellipsoid, const View& view) {
  return std::max(ellipsoid.geodeticFromBody(view.eye).height_m, kLeastHeight_m);
}

struct Turn {
  geo::Vec3 axis{0.0, 0.0, 1.0};
  double angle = 0.0;  ///< radians, 0..pi
};

/// Of the camera's axes, seen from the body.
Turn turnBetween(const View& from, const View& to) {
  const geo::Mat3 r = glm::transpose(to.viewFromBody) * from.viewFromBody;
  const geo::Vec3 twice(r[1][2] - r[2][1], r[2][0] - r[0][2], r[0][1] - r[1][0]);
  const double sine = geo::length(twice) / 2.0;
  if (sine == 0.0) return {};
  return {.axis = twice / (2.0 * sine), .angle = std::atan2(sine, (r[0][0] + r[1][1] + r[2][2] - 1.0) / 2.0)};
}

/// Of the eye, around the body's centre.
Turn wayBetween(const View& from, const View& to) {
  const geo::Vec3 cross = geo::cross(from.eye.m, to.eye.m);
  const double sine = geo::length(cross);
  if (sine == 0.0) return {};
  return {.axis = cross / sine, .angle = std::atan2(sine, geo::dot(from.eye.m, to.eye.m))};
}

geo::Vec3 turned(const geo::Vec3& v, const Turn& turn) {
  const double cosine = std::cos(turn.angle);
  return v * cosine + geo::cross(turn.axis, v) * std::sin(turn.angle) +
         turn.axis * (geo::dot(turn.axis, v) * (1.0 - cosine));
}

}  // namespace

void ViewMotion::add(const View& view, double time_s) {
  if (count_ > 0) {
    const Moment& last = moments_.back();
    const bool isLeap = geo::length(view.eye - last.view.eye) > kLeap * heightOf(ellipsoid_, last.view) ||
                        turnBetween(last.view, view).angle > kLeapAngle;
    if (time_s < last.time_s || time_s - last.time_s > kPause_s || isLeap) forget();
  }
  const bool isSpaced = count_ >= 2 && moments_[2].time_s - moments_[1].time_s >= kSpacing_s;
  if (count_ == 1 || isSpaced) {
    moments_[0] = moments_[1];
    moments_[1] = moments_[2];
    count_ = std::min<std::size_t>(count_ + 1, moments_.size());
  }
  count_ = std::max<std::size_t>(count_, 1);
  moments_.back() = {.view = view, .time_s = time_s};
}

std::optional<View> ViewMotion::ahead(double seconds) const {
  if (count_ < 2) return std::nullopt;
  const Moment& first = moments_[moments_.size() - count_];
  const Moment& last = moments_.back();
  const double since_s = last.time_s - first.time_s;
  if (since_s < kShortest_s) return std::nullopt;
  const double times = seconds / since_s;
  const double height_m = heightOf(ellipsoid_, last.view);
  const double distance_m = geo::length(last.view.eye.m);
  Turn way = wayBetween(first.view, last.view);
  Turn turn = turnBetween(first.view, last.view);
  way.angle = std::min(way.angle * times, kFarthest * height_m / distance_m);
  turn.angle = std::min(turn.angle * times, kMostTurn);
  const double climb =
      std::clamp(std::pow(height_m / heightOf(ellipsoid_, first.view), times), 1.0 / kMostClimb, kMostClimb);
  if (way.angle * distance_m < kRest * height_m && turn.angle < kRest && std::abs(climb - 1.0) < kRest) {
    return std::nullopt;
  }
  View view = last.view;
  geo::Geodetic place = ellipsoid_.geodeticFromBody({turned(view.eye.m, way)});
  place.height_m = height_m * climb;
  view.eye = ellipsoid_.bodyFromGeodetic(place);
  geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  for (int axis = 0; axis < 3; ++axis)
    bodyFromView[axis] = turned(bodyFromView[axis], turn);
  view.viewFromBody = glm::transpose(bodyFromView);
  return view;
}

}  // namespace tellurion::scene
