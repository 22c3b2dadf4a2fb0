#pragma once

#include <optional>

#include "app/eye_motion.h"
#include "app/view_input.h"
#include "app/walking.h"
#include "scene/coast.h"

namespace tellurion::app {

/// Turns what the hand does into views (docs/viewer.md has the table). Holds the gesture that is under way. One thread
/// only.
class ViewControls {
 public:
  explicit ViewControls(const scene::View& start) : start_(start), wished_(start), view_(start) {}

  const scene::View& view() const { return view_; }
  void resize(scene::Viewport viewport);
  /// Lifts the eye over ground that has arrived, and lets it down again to where the hand had put it when the ground
  /// turns out to be lower: coarse ground, which comes first, may be hundreds of metres off. A gesture goes on.
  void keepAboveGround(const scene::Ground& ground) { view_ = scene::cleared(wished_, ground); }
  bool dragging() const { return drag_.has_value(); }

  /// True when the view has changed. now_s: seconds on any steady clock, the one of advance().
  bool handle(const InputEvent& event, const scene::Ground& ground, double now_s);

  /// Whether the eye moves by itself. While it does, advance() before each picture; true: the view has changed.
  bool moving() const { return motion_.has_value() || (walking_ && walking_->moving()); }
  bool advance(const scene::Ground& ground, double now_s);
  /// Leaves the eye where it is.
  void stop() {
    motion_.reset();
    landsTo_.reset();
  }
  void flyTo(const scene::View& target, const scene::Ground& ground, double now_s);
  void begin(EyeMotion motion);

  /// Keys lead the eye from now on; the same gait again ends it. A walk that is asked for from high above begins with
  /// a flight to the ground. Flights and paths end it too.
  void toggle(Gait gait, const scene::Ground& ground, double now_s);
  /// Null unless keys lead the eye.
  const Walking* walking() const { return walking_ ? &*walking_ : nullptr; }

  /// Whether a drag goes on for a while when the hand lets go.
  bool& inertia() { return inertia_; }

 private:
  enum class Gesture { pan, look, orbit };
  struct Drag {
    Gesture gesture = Gesture::pan;
    MouseButton button = MouseButton::left;
    scene::PixelPosition from;
    scene::View view;
    std::optional<scene::Grip> grip;
  };

  bool changed(const scene::View& wished);
  void endWalk();
  std::optional<bool> handledByWalk(const InputEvent& event, const scene::Ground& ground, double now_s);
  bool handleButton(const ButtonChanged& event, const scene::Ground& ground, double now_s);
  bool handleKey(const KeyPressed& event, const scene::Ground& ground, double now_s);
  bool isDoubleClick(const ButtonChanged& event);
  void beginDrag(const ButtonChanged& event, const scene::Ground& ground);
  bool dragTo(scene::PixelPosition cursor, const scene::Ground& ground);
  static scene::View dragged(const Drag& drag, scene::PixelPosition cursor, const scene::Ground& ground);
  void letGo(const ButtonChanged& event, const scene::Ground& ground, double now_s);
  bool zoomAt(scene::PixelPosition pixel, double steps, const scene::Ground& ground, double now_s);
  bool leapTowards(scene::PixelPosition pixel, const scene::Ground& ground, double now_s);
  bool arrow(double right, double up, Modifiers modifiers, const scene::Ground& ground);

  scene::View start_;
  scene::View wished_;  ///< where the hand has put the eye
  scene::View view_;    ///< the same, above the ground
  std::optional<Drag> drag_;
  std::optional<ButtonChanged> lastPress_;
  std::optional<EyeMotion> motion_;
  scene::HandSpeed hand_;  ///< of the drag under way
  bool inertia_ = true;
  std::optional<Walking> walking_;
  std::optional<Gait> landsTo_;  ///< once the flight has ended
  double pace_ = 1.0;            ///< of the last walk
};

}  // namespace tellurion::app
