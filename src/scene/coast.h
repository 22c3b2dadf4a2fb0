#pragma once

#include <array>
#include <cstddef>

#include "scene/navigation.h"

// A drag that goes on when the hand lets go, ever slower.
namespace tellurion::scene {

/// When it stands still.
inline constexpr double kCoast_s = 1.5;

/// How fast the hand was at the end of a drag. One thread only.
class HandSpeed {
 public:
  void forget() { count_ = 0; }
  /// Times do not fall.
  void add(PixelPosition cursor, double time_s);
  /// Pixels a second, over the last tenth of a second; 0 for a hand that rested before, or is not known.
  geo::Vec2 at(double time_s) const;

 private:
  struct Moment {
    PixelPosition cursor;
    double time_s = 0.0;
  };
  std::array<Moment, 16> moments_;  ///< a ring
  std::size_t count_ = 0;
};

/// How many seconds at the first speed what decays so far is as long as: at most 0.3.
double coastedSeconds(double seconds);

/// How the eye goes around the body's centre between two views: axis times radians.
geo::Vec3 turnBetween(const View& from, const View& to);
/// Its angle in radians.
double wayBetween(const View& from, const View& to);

/// The view so many seconds after the hand let go, when the eye went around the body's centre as `turn` says, in
/// radians a second; heading as in panning. From kCoast_s on always the same.
View coasted(const View& start, const geo::Vec3& turn, double seconds, const Ground& ground);

}  // namespace tellurion::scene
