#pragma once

#include <optional>

#include "app/view_input.h"
#include "scene/navigation.h"

namespace tellurion::app {

/// Turns what the hand does into views (docs/viewer.md has the table). Holds the gesture that is under way. One thread
/// only.
class ViewControls {
 public:
  explicit ViewControls(const scene::View& start) : start_(start), view_(start) {}

  const scene::View& view() const { return view_; }
  /// The eye is moved by others (resized, pushed up by ground that arrived): the gesture goes on.
  void resize(scene::Viewport viewport);
  void keepAboveGround(const scene::Ground& ground) { view_ = scene::cleared(view_, ground); }
  bool dragging() const { return drag_.has_value(); }

  /// True when the view has changed.
  bool handle(const InputEvent& event, const scene::Ground& ground);

 private:
  enum class Gesture { pan, look, orbit };
  struct Drag {
    Gesture gesture = Gesture::pan;
    MouseButton button = MouseButton::left;
    scene::PixelPosition from;
    scene::View view;
    std::optional<scene::Grip> grip;
  };

  bool handleButton(const ButtonChanged& event, const scene::Ground& ground);
  bool handleKey(const KeyPressed& event, const scene::Ground& ground);
  bool isDoubleClick(const ButtonChanged& event);
  void beginDrag(const ButtonChanged& event, const scene::Ground& ground);
  void dragTo(scene::PixelPosition cursor, const scene::Ground& ground);
  void zoomAt(scene::PixelPosition pixel, double steps, const scene::Ground& ground);
  void arrow(double right, double up, Modifiers modifiers, const scene::Ground& ground);

  scene::View start_;
  scene::View view_;
  std::optional<Drag> drag_;
  std::optional<ButtonChanged> lastPress_;
};

}  // namespace tellurion::app
