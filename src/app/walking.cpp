#include "app/walking.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/pose.h"

namespace tellurion::app {
namespace {

constexpr double kRun_mps = 5.0;
constexpr double kFly_per_s = 0.5;  // of the height above the ground
constexpr double kFaster = 10.0;    // with Shift
constexpr double kPaceStep = 1.25;
constexpr double kLeastPace = 0.1;
constexpr double kGreatestPace = 100.0;
constexpr double kLongest_s = 1.0;  // of one advance: what a program that hung has missed is not made up for

}  // namespace

scene::Stride Walking::stride() const {
  const auto between = [this](MotionKey more, MotionKey less) { return double(holds(more)) - double(holds(less)); };
  scene::Stride stride{.ahead = between(MotionKey::ahead, MotionKey::back),
                       .right = between(MotionKey::right, MotionKey::left)};
  if (gait_ == Gait::fly) stride.up = between(MotionKey::up, MotionKey::down);
  return stride;
}

double Walking::factor() const {
  return pace_ * (holds(MotionKey::faster) ? kFaster : 1.0);
}

bool Walking::advance(const scene::Ground& ground, double now_s) {
  const double seconds = std::clamp(now_s - last_s_, 0.0, kLongest_s);
  last_s_ = now_s;
  const geo::BodyPosition before = walker_.view.eye;
  const scene::Stride now = stride();
  if (gait_ == Gait::walk) {
    walker_ = scene::walked(walker_, now, kRun_mps * factor(), seconds, ground);
    settled_ = scene::stands(walker_, ground);
  } else {
    walker_.view = scene::flown(walker_.view, now, kFly_per_s * factor(), seconds, ground);
    settled_ = true;
  }
  return walker_.view.eye != before;
}

bool Walking::handle(const InputEvent& event, const scene::Ground& ground, double now_s) {
  if (const auto* key = std::get_if<MotionKeyChanged>(&event)) {
    if (moving()) advance(ground, now_s);  // with what was down until now
    last_s_ = now_s;
    held_[static_cast<std::size_t>(key->key)] = key->down;
    return true;
  }
  if (const auto* wheel = std::get_if<WheelTurned>(&event)) {
    if (moving()) advance(ground, now_s);
    pace_ = std::clamp(pace_ * std::pow(kPaceStep, wheel->steps), kLeastPace, kGreatestPace);
    return false;
  }
  if (const auto* button = std::get_if<ButtonChanged>(&event)) {
    if (button->down) {
      dragged_ = *button;
      cursor_ = button->at;
      return false;
    }
    if (dragged_ && dragged_->button == button->button) dragged_.reset();
    return false;
  }
  const auto* cursor = std::get_if<CursorMoved>(&event);
  if (!cursor || !dragged_) return false;
  const geo::Vec2 drag_px(cursor->at.x - cursor_.x, cursor->at.y - cursor_.y);
  cursor_ = cursor->at;
  walker_.view = scene::lookedAround(walker_.view, drag_px, ground);
  return true;
}

void Walking::turnNorthUp(const scene::Ground& ground) {
  walker_.view = scene::northUp(walker_.view, std::nullopt, ground);
}

std::string Walking::status() const {
  if (gait_ == Gait::walk) return fmt::format("walking, {:.3g} m/s", kRun_mps * factor());
  return fmt::format("flying, {:.3g} of the height a second", kFly_per_s * factor());
}

scene::View landing(const scene::View& view, const scene::Ground& ground) {
  const auto grip = scene::gripAt(view, scene::centreOf(view.viewport), ground);
  scene::Pose pose = scene::poseOf(view, ground.ellipsoid);
  const geo::Direction place = grip ? ground.ellipsoid.directionFromBody(grip->point) : pose.up;
  pose = scene::carriedTo(pose, place, scene::leastHeight_m(place, ground));
  pose.pitch = geo::Angle::degrees(0);
  return scene::viewOf(pose, ground.ellipsoid, view);
}

}  // namespace tellurion::app
