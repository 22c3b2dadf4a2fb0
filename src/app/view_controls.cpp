#include "app/view_controls.h"

#include <cmath>

namespace tellurion::app {
namespace {

constexpr double kDoubleClick_s = 0.35;
constexpr double kDoubleClick_px = 5.0;
constexpr double kDoubleClickSteps = 5.0;
constexpr double kKeySteps = 2.0;
/// What an arrow key moves, as a share of the picture's height.
constexpr double kArrowShare = 0.1;

double distanceBetween(scene::PixelPosition a, scene::PixelPosition b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

geo::Vec2 difference(scene::PixelPosition to, scene::PixelPosition from) {
  return {to.x - from.x, to.y - from.y};
}

}  // namespace

void ViewControls::resize(scene::Viewport viewport) {
  for (scene::View* view : {&start_, &wished_, &view_})
    view->viewport = viewport;
  drag_.reset();
}

bool ViewControls::changed(const scene::View& wished) {
  wished_ = wished;
  view_ = wished;
  return true;
}

bool ViewControls::handle(const InputEvent& event, const scene::Ground& ground) {
  if (const auto* button = std::get_if<ButtonChanged>(&event)) return handleButton(*button, ground);
  if (const auto* key = std::get_if<KeyPressed>(&event)) return handleKey(*key, ground);
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) return zoomAt(wheel->at, wheel->steps, ground);
  const auto* cursor = std::get_if<CursorMoved>(&event);
  return cursor && drag_ && dragTo(cursor->at, ground);
}

bool ViewControls::handleButton(const ButtonChanged& event, const scene::Ground& ground) {
  if (!event.down) {
    if (!drag_ || drag_->button != event.button) return false;
    const bool moved = distanceBetween(event.at, drag_->from) > 0.0 && dragTo(event.at, ground);
    drag_.reset();
    return moved;
  }
  if (isDoubleClick(event)) return zoomAt(event.at, kDoubleClickSteps, ground);
  beginDrag(event, ground);
  return false;
}

bool ViewControls::isDoubleClick(const ButtonChanged& event) {
  if (event.button != MouseButton::left) return false;
  const bool second = lastPress_ && event.seconds - lastPress_->seconds < kDoubleClick_s &&
                      distanceBetween(event.at, lastPress_->at) < kDoubleClick_px;
  lastPress_ = second ? std::nullopt : std::optional(event);
  return second;
}

void ViewControls::beginDrag(const ButtonChanged& event, const scene::Ground& ground) {
  Gesture gesture = Gesture::pan;
  if (event.button == MouseButton::right || event.modifiers.shift) gesture = Gesture::look;
  if (event.button == MouseButton::middle || event.modifiers.control) gesture = Gesture::orbit;
  auto grip = scene::gripAt(view_, event.at, ground);
  if (!grip && gesture == Gesture::orbit) grip = scene::gripAt(view_, scene::centreOf(view_.viewport), ground);
  if (!grip) gesture = Gesture::look;
  drag_ = Drag{gesture, event.button, event.at, view_, grip};
}

bool ViewControls::dragTo(scene::PixelPosition cursor, const scene::Ground& ground) {
  const geo::Vec2 drag_px = difference(cursor, drag_->from);
  switch (drag_->gesture) {
    case Gesture::pan:
      return changed(scene::panned(drag_->view, *drag_->grip, cursor, ground));
    case Gesture::look:
      return changed(scene::lookedAround(drag_->view, drag_px, ground));
    case Gesture::orbit:
      return changed(scene::orbited(drag_->view, *drag_->grip, drag_px, ground));
  }
  return false;
}

bool ViewControls::zoomAt(scene::PixelPosition pixel, double steps, const scene::Ground& ground) {
  drag_.reset();
  const auto grip = scene::gripAt(view_, pixel, ground);
  return changed(grip ? scene::zoomed(view_, *grip, steps, ground) : scene::climbed(view_, steps, ground));
}

bool ViewControls::arrow(double right, double up, Modifiers modifiers, const scene::Ground& ground) {
  drag_.reset();
  const scene::PixelPosition centre = scene::centreOf(view_.viewport);
  const double step_px = kArrowShare * view_.viewport.height;
  const geo::Vec2 drag_px(-right * step_px, up * step_px);
  const auto grip = scene::gripAt(view_, centre, ground);
  if (!grip || modifiers.shift) return changed(scene::lookedAround(view_, drag_px, ground));
  if (modifiers.control) return changed(scene::orbited(view_, *grip, drag_px, ground));
  return changed(scene::panned(view_, *grip, {centre.x + drag_px.x, centre.y + drag_px.y}, ground));
}

bool ViewControls::handleKey(const KeyPressed& event, const scene::Ground& ground) {
  const scene::PixelPosition centre = scene::centreOf(view_.viewport);
  switch (event.key) {
    case ViewKey::plus:
      return zoomAt(centre, kKeySteps, ground);
    case ViewKey::minus:
      return zoomAt(centre, -kKeySteps, ground);
    case ViewKey::left:
      return arrow(-1, 0, event.modifiers, ground);
    case ViewKey::right:
      return arrow(1, 0, event.modifiers, ground);
    case ViewKey::up:
      return arrow(0, 1, event.modifiers, ground);
    case ViewKey::down:
      return arrow(0, -1, event.modifiers, ground);
    case ViewKey::north:
      drag_.reset();
      return changed(scene::northUp(view_, scene::gripAt(view_, centre, ground), ground));
    case ViewKey::reset:
      drag_.reset();
      return changed(start_);
    case ViewKey::light:
    case ViewKey::printCamera:
    case ViewKey::help:
    case ViewKey::screenshot:
    case ViewKey::quit:
    case ViewKey::escape:
    case ViewKey::wireframe:
    case ViewKey::levels:
    case ViewKey::error:
    case ViewKey::boxes:
    case ViewKey::freeze:
    case ViewKey::higher:
    case ViewKey::lower:
    case ViewKey::finer:
    case ViewKey::coarser:
    case ViewKey::automatic:
    case ViewKey::layers:
    case ViewKey::play:
    case ViewKey::earlier:
    case ViewKey::later:
    case ViewKey::air:
    case ViewKey::statistics:
      return false;
  }
  return false;
}

}  // namespace tellurion::app
