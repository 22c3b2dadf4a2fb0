#include "app/view_travel.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

namespace tellurion::app {
namespace {

constexpr int kMostPaths = 100000;

}  // namespace

scene::Camera ViewTravel::camera() const {
  return scene::cameraOf(controls_.view(), ground_.ellipsoid);
}

void ViewTravel::flyTo(const scene::Camera& camera, double now_s) {
  const scene::View& now = controls_.view();
  controls_.flyTo(scene::viewOf(camera, ground_.ellipsoid, now.verticalFov, now.viewport), ground_, now_s);
}

void ViewTravel::setKeyFrames(std::vector<scene::KeyFrame> frames) {
  keyFrames_.frames() = std::move(frames);
  keyFrames_.shown() = true;
}

void ViewTravel::handle(ViewKey key, double now_s) {
  if (key == ViewKey::goTo) goTo_.open();
  if (key == ViewKey::escape) goTo_.close();
  if (key == ViewKey::bookmarks) bookmarks_.shown() = !bookmarks_.shown();
  if (key == ViewKey::keyFrames) keyFrames_.shown() = !keyFrames_.shown();
  if (key == ViewKey::record) toggleRecording(now_s);
  if (key == ViewKey::addKeyFrame) {
    keyFrames_.frames().push_back({.camera = camera()});
    keyFrames_.shown() = true;
  }
  if (key == ViewKey::walk || key == ViewKey::fly) toggleWalk(key == ViewKey::walk ? Gait::walk : Gait::fly, now_s);
  if (key == ViewKey::inertia) {
    controls_.inertia() = !controls_.inertia();
    notify_(controls_.inertia() ? "a drag goes on when let go" : "a drag ends where it is let go");
  }
}

void ViewTravel::toggleWalk(Gait gait, double now_s) {
  controls_.toggle(gait, ground_, now_s);
  if (const Walking* const walking = controls_.walking(); walking == nullptr) {
    notify_(controls_.moving() ? "landing, to walk" : "keys lead the picture again");
  } else if (gait == Gait::walk) {
    notify_("walking: W A S D or arrows, drag to look around, Shift: faster, wheel: pace, T: end");
  } else {
    notify_("flying: W A S D or arrows, Page Up and Down, drag to look around, Shift: faster, wheel: pace, U: end");
  }
}

void ViewTravel::drawn(double now_s) {
  if (recorder_) recorder_->add(camera(), now_s);
}

void ViewTravel::toggleRecording(double now_s) {
  if (!recorder_) {
    recorder_.emplace();
    drawn(now_s);
    notify_("recording the way of the eye; F9 ends it");
    return;
  }
  drawn(now_s);
  const auto keys = recorder_->keys();
  recorder_.reset();
  save(keys);
}

/// Under the next free name of the current folder.
void ViewTravel::save(std::span<const scene::CameraPath::Key> keys) {
  std::error_code ignored;
  for (int i = 1; i < kMostPaths; ++i) {
    const std::filesystem::path path = fmt::format("tellurion-path-{:04}.csv", i);
    if (std::filesystem::exists(path, ignored)) continue;
    std::ofstream file(path, std::ios::binary);
    file << scene::formatCameraPath(keys) << std::flush;
    const std::string where = std::filesystem::absolute(path, ignored).string();
    const bool saved = file.good();
    fmt::print(stderr, "{}{}\n", saved ? "camera path: " : "not written: ", where);
    notify_(saved ? fmt::format("saved {} keys in {}", keys.size(), where) : "cannot be written: " + where);
    return;
  }
}

void ViewTravel::play(double now_s) {
  auto path = scene::CameraPath::create(scene::keysOf(keyFrames_.frames()));
  if (!path) {
    notify_(io::describe(path.error()));
    return;
  }
  controls_.begin(alongPath(std::move(*path), controls_.view(), now_s));
}

bool ViewTravel::draw(double now_s) {
  if (goTo_.shown()) {
    if (const auto asked = goTo_.draw(controls_.view(), ground_)) controls_.flyTo(*asked, ground_, now_s);
  }
  if (bookmarks_.shown()) {
    if (const auto asked = bookmarks_.draw(camera())) flyTo(*asked, now_s);
  }
  if (keyFrames_.shown()) {
    const auto asked = keyFrames_.draw(camera());
    if (std::holds_alternative<KeyFramePanel::Play>(asked)) play(now_s);
    if (std::holds_alternative<KeyFramePanel::Save>(asked)) save(scene::keysOf(keyFrames_.frames()));
    if (const auto* to = std::get_if<scene::Camera>(&asked)) flyTo(*to, now_s);
  }
  return controls_.moving();
}

}  // namespace tellurion::app
