#pragma once

#include <vector>

#include "scene/camera_path.h"

namespace tellurion::scene {

/// A camera's way as it is flown, as keys of a CameraPath that begins at 0 s. One thread only.
class CameraRecorder {
 public:
  /// A camera at a time in seconds of any steady clock, which does not fall. Remembered 30 times a second at most, 64
  /// bytes each; a camera that stands for so long, when it stops and when it moves on.
  void add(const Camera& camera, double time_s);
  /// All so far, as few keys as lead the spline by what is remembered: to a quarter of the way to the moment before or
  /// after, that is 8 ms of it, and to 1 cm and 0.01 degrees. A stand is two keys. Empty: nothing was added; one key:
  /// nothing but one moment. Some microseconds for each moment.
  std::vector<CameraPath::Key> keys() const;

 private:
  void remember(const CameraPath::Key& moment);
  void rememberLast();

  double begin_s_ = 0.0;
  std::vector<CameraPath::Key> moments_;
  CameraPath::Key standsSince_;  ///< the first with the camera of the last
  CameraPath::Key last_;
};

}  // namespace tellurion::scene
