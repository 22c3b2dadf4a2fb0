#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "scene/camera_path.h"

// A camera path as a person edits it: views, and how long the eye takes from each to the next.
namespace tellurion::scene {

struct KeyFrame {
  Camera camera;
  double leg_s = 3.0;  ///< from the frame before; of the first one without meaning
};

/// The shortest leg: two keys of a path never lie at the same time.
inline constexpr double kLeastLeg_s = 0.01;

/// Begins at 0 s. Legs shorter than kLeastLeg_s, or that are no number, count as that; long ones are what they are.
std::vector<CameraPath::Key> keysOf(std::span<const KeyFrame> frames);
std::vector<KeyFrame> keyFramesOf(std::span<const CameraPath::Key> keys);

/// The frame at `from` comes to stand at `to`, the others closing up; legs stay with their views. Places that are not
/// there change nothing.
void moveKeyFrame(std::vector<KeyFrame>& frames, std::size_t from, std::size_t to);

}  // namespace tellurion::scene
