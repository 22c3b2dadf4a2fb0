#pragma once

#include <array>
#include <string>

#include "app/view_input.h"
#include "scene/walk.h"

namespace tellurion::app {

enum class Gait { walk, fly };

/// The eye while keys lead it over the ground (docs/viewer.md). Keys count by how long they are down, on the clock of
/// the frames. One thread only.
class Walking {
 public:
  Walking(Gait gait, const scene::View& start, double pace, double now_s)
      : gait_(gait), walker_{start, 0.0}, pace_(pace), last_s_(now_s) {}

  Gait gait() const { return gait_; }
  const scene::View& view() const { return walker_.view; }
  double pace() const { return pace_; }

  /// True: the view changes, now or while time passes.
  bool handle(const InputEvent& event, const scene::Ground& ground, double now_s);
  /// A turn of the eye by hand ends with it; keys stay down.
  void resize(scene::Viewport viewport) {
    walker_.view.viewport = viewport;
    dragged_.reset();
  }
  /// Up to now; true: the view has changed.
  bool advance(const scene::Ground& ground, double now_s);
  /// Whether the eye moves without another event.
  bool moving() const { return !stride().rests() || !settled_; }
  void turnNorthUp(const scene::Ground& ground);

  /// "walking, 5 m/s".
  std::string status() const;

 private:
  bool holds(MotionKey key) const { return held_[static_cast<std::size_t>(key)]; }
  scene::Stride stride() const;
  double factor() const;

  Gait gait_;
  scene::Walker walker_;
  double pace_;  ///< 1: a run
  double last_s_;
  bool settled_ = false;
  std::array<bool, kMotionKeys> held_{};
  std::optional<ButtonChanged> dragged_;  ///< the button that turns the eye
  scene::PixelPosition cursor_;           ///< up to where it has
};

/// Where a walk begins that is asked for high above: level on the ground under the middle of the picture, or under the
/// eye where that shows the sky.
scene::View landing(const scene::View& view, const scene::Ground& ground);

}  // namespace tellurion::app
