#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "geo/ellipsoid.h"
#include "scene/camera.h"

namespace tellurion::scene {

/// Whither an eye moves and turns, from the views of the last frames. One thread only.
class ViewMotion {
 public:
  explicit ViewMotion(const geo::Ellipsoid& ellipsoid) : ellipsoid_(ellipsoid) {}

  /// The view at a time in seconds. A time before the last one, a pause or a leap begin anew.
  void add(const View& view, double time_s);
  void forget() { count_ = 0; }
  /// The view after so many seconds, > 0, if the eye goes on around the body, turns and changes its height by the same
  /// factor as in the last tenths of a second; all three bounded, since no one goes on like that for long. Nothing when
  /// it rests or too little is known.
  std::optional<View> ahead(double seconds) const;

 private:
  struct Moment {
    View view;
    double time_s = 0.0;
  };
  geo::Ellipsoid ellipsoid_;
  std::array<Moment, 3> moments_;  ///< the newest last; the others lie kSpacing_s before it and each other, or more
  std::size_t count_ = 0;          ///< of them that are known, the last ones
};

}  // namespace tellurion::scene
