#pragma once

#include <optional>
#include <vector>

#include "scene/camera_path.h"

namespace tellurion::scene {

/// A camera's way as it is flown, as keys of a CameraPath that begins at 0 s. One thread only.
class CameraRecorder {
 public:
  /// A camera at a time in seconds of any steady clock, which does not fall. Kept 30 times a second at most; while it
  /// stands still, once when it stops and once before it moves on.
  void add(const Camera& camera, double time_s);
  /// All so far. Empty: nothing was added; one key: nothing but one moment.
  std::vector<CameraPath::Key> keys() const;

 private:
  std::optional<double> begin_s_;
  std::vector<CameraPath::Key> kept_;
  std::optional<CameraPath::Key> last_;  ///< the newest, where it is not kept
};

}  // namespace tellurion::scene
