#include "app/view_controls.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tellurion::app {
namespace {

constexpr double kDoubleClick_s = 0.35;
constexpr double kDoubleClick_px = 5.0;
constexpr double kDoubleClickSteps = 5.0;
constexpr double kLeastThrow = 60.0;    // pixels a second: a slower hand has put down what it held
constexpr double kWalksFrom_m = 100.0;  // above the ground; from higher it flies there first
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
  stop();
  if (walking_) walking_->resize(viewport);
}

bool ViewControls::changed(const scene::View& wished) {
  wished_ = wished;
  view_ = wished;
  return true;
}

bool ViewControls::handle(const InputEvent& event, const scene::Ground& ground, double now_s) {
  if (const auto done = handledByWalk(event, ground, now_s)) return *done;
  if (const auto* button = std::get_if<ButtonChanged>(&event)) return handleButton(*button, ground, now_s);
  if (const auto* key = std::get_if<KeyPressed>(&event)) return handleKey(*key, ground, now_s);
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) return zoomAt(wheel->at, wheel->steps, ground, now_s);
  const auto* cursor = std::get_if<CursorMoved>(&event);
  if (!cursor || !drag_) return false;
  hand_.add(cursor->at, cursor->seconds);
  return dragTo(cursor->at, ground);
}

bool ViewControls::advance(const scene::Ground& ground, double now_s) {
  if (walking_) {
    if (!walking_->advance(ground, now_s)) return false;
    return changed(walking_->view());
  }
  if (!motion_) return false;
  const double seconds = now_s - motion_->begin_s;
  changed(motion_->viewAt(std::clamp(seconds, 0.0, motion_->duration_s), ground));
  if (seconds < motion_->duration_s) return true;
  const auto gait = landsTo_;
  stop();
  if (gait) walking_.emplace(*gait, wished_, pace_, now_s);
  return true;
}

void ViewControls::endWalk() {
  if (walking_) pace_ = walking_->pace();
  walking_.reset();
}

void ViewControls::toggle(Gait gait, const scene::Ground& ground, double now_s) {
  const bool same = (walking_ && walking_->gait() == gait) || landsTo_ == gait;
  endWalk();
  drag_.reset();
  stop();
  if (same) return;
  if (gait == Gait::walk && scene::heightAboveGround_m(view_.eye, ground) > kWalksFrom_m) {
    flyTo(landing(view_, ground), ground, now_s);
    landsTo_ = gait;
  } else {
    walking_.emplace(gait, view_, pace_, now_s);
  }
}

/// Nothing: the event is for the other controls.
std::optional<bool> ViewControls::handledByWalk(const InputEvent& event, const scene::Ground& ground, double now_s) {
  if (!walking_) return std::nullopt;
  if (const auto* key = std::get_if<KeyPressed>(&event)) {
    if (key->key == ViewKey::north) {
      walking_->turnNorthUp(ground);
      return changed(walking_->view());
    }
    return key->key == ViewKey::reset ? std::nullopt : std::optional(false);
  }
  if (!walking_->handle(event, ground, now_s)) return false;
  return changed(walking_->view());
}

void ViewControls::flyTo(const scene::View& target, const scene::Ground& ground, double now_s) {
  begin(flightTo(view_, target, ground, now_s));
}

void ViewControls::begin(EyeMotion motion) {
  drag_.reset();
  endWalk();
  landsTo_.reset();
  motion_ = std::move(motion);
}

bool ViewControls::handleButton(const ButtonChanged& event, const scene::Ground& ground, double now_s) {
  if (!event.down) {
    if (!drag_ || drag_->button != event.button) return false;
    const double far_px = distanceBetween(event.at, drag_->from);
    const bool moved = far_px > 0.0 && dragTo(event.at, ground);
    if (far_px >= kDoubleClick_px) lastPress_.reset();  // what was thrown was not clicked
    if (moved && inertia_) letGo(event, ground, now_s);
    drag_.reset();
    return moved;
  }
  stop();
  if (isDoubleClick(event)) return leapTowards(event.at, ground, now_s);
  beginDrag(event, ground);
  return false;
}

/// The drag goes on as fast as the hand was.
void ViewControls::letGo(const ButtonChanged& event, const scene::Ground& ground, double now_s) {
  constexpr double kBefore_s = 0.02;
  const geo::Vec2 speed = hand_.at(event.seconds);
  if (geo::length(speed) < kLeastThrow) return;
  const Drag drag = *drag_;
  const auto shifted = [&event, speed](double seconds) {
    return scene::PixelPosition{event.at.x + speed.x * seconds, event.at.y + speed.y * seconds};
  };
  EyeMotion motion{.begin_s = now_s, .duration_s = scene::kCoast_s, .viewAt = {}};
  if (drag.gesture == Gesture::pan) {
    // Around the body, and not on with the cursor, which would stop at the rim.
    const geo::Vec3 turn = scene::turnBetween(dragged(drag, shifted(-kBefore_s), ground), view_) / kBefore_s;
    motion.viewAt = [start = wished_, turn](double seconds, const scene::Ground& now) {
      return scene::coasted(start, turn, seconds, now);
    };
  } else {
    motion.viewAt = [drag, shifted](double seconds, const scene::Ground& now) {
      return dragged(drag, shifted(scene::coastedSeconds(seconds)), now);
    };
  }
  motion_ = std::move(motion);
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
  hand_.forget();
  hand_.add(event.at, event.seconds);
}

bool ViewControls::dragTo(scene::PixelPosition cursor, const scene::Ground& ground) {
  return changed(dragged(*drag_, cursor, ground));
}

scene::View ViewControls::dragged(const Drag& drag, scene::PixelPosition cursor, const scene::Ground& ground) {
  const geo::Vec2 drag_px = difference(cursor, drag.from);
  switch (drag.gesture) {
    case Gesture::pan:
      return scene::panned(drag.view, *drag.grip, cursor, ground);
    case Gesture::look:
      return scene::lookedAround(drag.view, drag_px, ground);
    case Gesture::orbit:
      return scene::orbited(drag.view, *drag.grip, drag_px, ground);
  }
  return drag.view;
}

/// What an earlier turn of the wheel has left to do is done with this one.
bool ViewControls::zoomAt(scene::PixelPosition pixel, double steps, const scene::Ground& ground, double now_s) {
  const double left = motion_ ? motion_->stepsLeft(now_s) : 0.0;
  advance(ground, now_s);  // to where this much is left
  begin(easedZoom(view_, scene::gripAt(view_, pixel, ground), left + steps, now_s));
  return true;
}

bool ViewControls::leapTowards(scene::PixelPosition pixel, const scene::Ground& ground, double now_s) {
  const auto grip = scene::gripAt(view_, pixel, ground);
  const scene::View target =
      grip ? scene::zoomed(view_, *grip, kDoubleClickSteps, ground) : scene::climbed(view_, kDoubleClickSteps, ground);
  flyTo(target, ground, now_s);
  return true;
}

bool ViewControls::arrow(double right, double up, Modifiers modifiers, const scene::Ground& ground) {
  drag_.reset();
  stop();
  const scene::PixelPosition centre = scene::centreOf(view_.viewport);
  const double step_px = kArrowShare * view_.viewport.height;
  const geo::Vec2 drag_px(-right * step_px, up * step_px);
  const auto grip = scene::gripAt(view_, centre, ground);
  if (!grip || modifiers.shift) return changed(scene::lookedAround(view_, drag_px, ground));
  if (modifiers.control) return changed(scene::orbited(view_, *grip, drag_px, ground));
  return changed(scene::panned(view_, *grip, {centre.x + drag_px.x, centre.y + drag_px.y}, ground));
}

bool ViewControls::handleKey(const KeyPressed& event, const scene::Ground& ground, double now_s) {
  const scene::PixelPosition centre = scene::centreOf(view_.viewport);
  switch (event.key) {
    case ViewKey::plus:
      return zoomAt(centre, kKeySteps, ground, now_s);
    case ViewKey::minus:
      return zoomAt(centre, -kKeySteps, ground, now_s);
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
      stop();
      return changed(scene::northUp(view_, scene::gripAt(view_, centre, ground), ground));
    case ViewKey::reset:
      flyTo(start_, ground, now_s);
      return true;
    case ViewKey::escape:
      stop();
      return false;
    case ViewKey::light:
    case ViewKey::printCamera:
    case ViewKey::help:
    case ViewKey::screenshot:
    case ViewKey::quit:
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
    case ViewKey::goTo:
    case ViewKey::bookmarks:
    case ViewKey::addKeyFrame:
    case ViewKey::keyFrames:
    case ViewKey::record:
    case ViewKey::inertia:
    case ViewKey::settings:
    case ViewKey::walk:
    case ViewKey::fly:
    case ViewKey::sources:
      return false;
  }
  return false;
}

}  // namespace tellurion::app
