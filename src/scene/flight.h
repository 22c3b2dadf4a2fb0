#pragma once

#include "scene/pose.h"

namespace tellurion::scene {

/// A flight from one view to another. Ground and height follow van Wijk and Nuij, "Smooth and efficient zooming and
/// panning" (2003): the path on which what is seen moves least in all, which rises as far as the way is long and comes
/// down again (rho = 1.42). Departures from the paper: the way over the ground is the great circle between the places
/// of the eyes; what it calls the width of the view is the eye's height above the ground; the pace eases in and out,
/// and the way around the body costs time too, which on a plane nobody sees from so high. Height goes from that above
/// the first ground to that above the last; ground that is higher in between is for the caller (`cleared`). Heading,
/// pitch and roll turn the shorter way; north stays where it is unless a pole is within 30 degrees of the way, where
/// the eye keeps its direction relative to the way instead. Immutable.
class Flight {
 public:
  /// Field of view and viewport are those of `from`. Places opposite to each other are joined by way of what lies
  /// ahead.
  Flight(const View& from, const View& to, const Ground& ground);

  /// 0 where there is nothing to do, else 0.3 to 10 seconds.
  double duration_s() const { return duration_s_; }
  /// Before the beginning `from`, after the end `to` (with the field of view and the viewport of `from`).
  View at(double seconds) const;

 private:
  struct Level {
    double over_m = 0.0;  ///< above the ground, never 0
    double share = 0.0;   ///< of the way over the ground
  };
  Level levelAt(double share) const;
  Pose poseAt(double share) const;
  double costUpTo(double share) const;
  double shareAt(double seconds) const;

  geo::Ellipsoid ellipsoid_;
  View from_;
  View to_;
  Pose fromPose_;
  Pose toPose_;
  geo::Vec3 axis_{0.0, 0.0, 1.0};  ///< of the great circle
  double angle_ = 0.0;             ///< radians, 0..pi
  bool keepsNorth_ = true;
  double turn_ = 0.0;  ///< radians, clockwise
  double fromGround_m_ = 0.0;
  double toGround_m_ = 0.0;
  double way_m_ = 0.0;
  double r0_ = 0.0;      ///< the paper's
  double length_ = 0.0;  ///< the paper's S
  double highest_m_ = 0.0;
  double duration_s_ = 0.0;
};

}  // namespace tellurion::scene
