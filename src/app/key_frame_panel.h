#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "scene/key_frames.h"

namespace tellurion::app {

/// The key frames of a camera path: listed, timed, moved, deleted, played and saved. Main thread only.
class KeyFramePanel {
 public:
  struct Play {};
  struct Save {};
  using Asked = std::variant<std::monostate, Play, Save, scene::Camera>;  ///< a camera: to be flown to

  bool& shown() { return shown_; }
  std::vector<scene::KeyFrame>& frames() { return frames_; }
  /// Between ViewWindow::beginPanels() and endPanels(). `now`: what "Add" adds.
  Asked draw(const scene::Camera& now);

 private:
  void drawFrame(std::size_t i, Asked& asked);

  std::vector<scene::KeyFrame> frames_;
  std::optional<std::size_t> deleted_;
  std::optional<std::pair<std::size_t, std::size_t>> moved_;
  bool shown_ = false;
};

}  // namespace tellurion::app
