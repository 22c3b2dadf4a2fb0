#include "scene/key_frames.h"

#include <algorithm>

namespace tellurion::scene {

std::vector<CameraPath::Key> keysOf(std::span<const KeyFrame> frames) {
  std::vector<CameraPath::Key> keys;
  double seconds = 0.0;
  for (const KeyFrame& frame : frames) {
    if (!keys.empty()) seconds += std::max(kLeastLeg_s, frame.leg_s);
    keys.push_back({.seconds = seconds, .camera = frame.camera});
  }
  return keys;
}

std::vector<KeyFrame> keyFramesOf(std::span<const CameraPath::Key> keys) {
  std::vector<KeyFrame> frames;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    frames.push_back({.camera = keys[i].camera});
    if (i > 0) frames.back().leg_s = keys[i].seconds - keys[i - 1].seconds;
  }
  return frames;
}

void moveKeyFrame(std::vector<KeyFrame>& frames, std::size_t from, std::size_t to) {
  if (from >= frames.size() || to >= frames.size()) return;
  const auto at = [&frames](std::size_t i) { return frames.begin() + static_cast<std::ptrdiff_t>(i); };
  if (from < to) std::rotate(at(from), at(from) + 1, at(to) + 1);
  if (to < from) std::rotate(at(to), at(from), at(from) + 1);
}

}  // namespace tellurion::scene
