#include "scene/coast.h"

#include <algorithm>
#include <cmath>

#include "scene/pose.h"

namespace tellurion::scene {
namespace {

constexpr double kDecay_s = 0.3;
constexpr double kMeasured_s = 0.1;
constexpr double kRested_s = 0.1;  ///< since the last move, which a hand that throws does not let pass
constexpr double kThinned_s = 0.01;
constexpr double kShortest_s = 0.005;  ///< over less no speed is told

}  // namespace

void HandSpeed::add(PixelPosition cursor, double time_s) {
  // Thinned, so that the ring is long enough for a mouse that tells of itself a thousand times a second.
  const bool isClose = count_ >= 2 && time_s - moments_[(count_ - 2) % moments_.size()].time_s < kThinned_s;
  if (!isClose) ++count_;
  moments_[(count_ - 1) % moments_.size()] = {cursor, time_s};
}

geo::Vec2 HandSpeed::at(double time_s) const {
  if (count_ < 2) return geo::Vec2(0.0);
  const Moment& last = moments_[(count_ - 1) % moments_.size()];
  if (time_s - last.time_s > kRested_s) return geo::Vec2(0.0);
  Moment first = last;
  for (std::size_t back = 2; back <= std::min(count_, moments_.size()); ++back) {
    const Moment& moment = moments_[(count_ - back) % moments_.size()];
    if (last.time_s - moment.time_s > kMeasured_s) {
      // A hand that stood, and then threw: it set out from there at some moment of the last tenth of a second.
      if (last.time_s - first.time_s < kShortest_s) first = {moment.cursor, last.time_s - kMeasured_s};
      break;
    }
    first = moment;
  }
  const double since_s = last.time_s - first.time_s;
  if (since_s < kShortest_s) return geo::Vec2(0.0);
  return geo::Vec2(last.cursor.x - first.cursor.x, last.cursor.y - first.cursor.y) / since_s;
}

double coastedSeconds(double seconds) {
  return kDecay_s * (1.0 - std::exp(-std::clamp(seconds, 0.0, kCoast_s) / kDecay_s));
}

geo::Vec3 turnBetween(const View& from, const View& to) {
  const geo::Vec3 across = geo::cross(from.eye.m, to.eye.m);
  const double sine = geo::length(across);
  return sine > 0.0 ? across * (std::atan2(sine, geo::dot(from.eye.m, to.eye.m)) / sine) : geo::Vec3(0.0);
}

double wayBetween(const View& from, const View& to) {
  return geo::length(turnBetween(from, to));
}

View coasted(const View& start, const geo::Vec3& turn, double seconds, const Ground& ground) {
  const Pose pose = poseOf(start, ground.ellipsoid);
  const double speed = geo::length(turn);
  if (!(speed > 0.0)) return cleared(start, ground);
  const geo::Vec3 axis = turn / speed;
  const double angle = speed * coastedSeconds(seconds);
  const geo::Vec3& eye = start.eye.m;
  const geo::Vec3 there = eye * std::cos(angle) + geo::cross(axis, eye) * std::sin(angle) +
                          axis * (geo::dot(axis, eye) * (1.0 - std::cos(angle)));
  const geo::Direction up = ground.ellipsoid.directionFromBody({there});
  return cleared(viewOf(carriedTo(pose, up, pose.height_m), ground.ellipsoid, start), ground);
}

}  // namespace tellurion::scene
