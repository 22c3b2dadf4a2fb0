#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/bookmark_panel.h"
#include "app/go_to_panel.h"
#include "app/key_frame_panel.h"
#include "app/view_controls.h"
#include "scene/camera_recorder.h"

namespace tellurion::app {

/// Where the eye can be sent and what way it has gone: places, key frames,
/// bookmarks, recording. Main thread only; controls and
/// ground must outlive it.
class ViewTravel {
 public:
  using Notify = std::function<void(std::string)>;
  ViewTravel(ViewControls& controls, const scene::Ground& ground, const std::string& body, scene::Gazetteer places,
             Notify notify)
      : controls_(controls),
        ground_(ground),
        goTo_(std::move(places)),
        bookmarks_(body, notify),
        notify_(std::move(notify)) {}

  void handle(ViewKey key, double now_s);
  /// After each picture, and before a recording ends.
  void drawn(double now_s);
  /// Between ViewWindow::beginPanels() and endPanels(). True: the eye is on its way.
  bool draw(double now_s);
  bool panelShown() { return goTo_.shown() || bookmarks_.shown() || keyFrames_.shown(); }
  /// Whether what is typed is for a panel.
  bool wantsText() const { return goTo_.shown(); }
  bool recording() const { return recorder_.has_value(); }
  /// Key frames to begin with.
  void setKeyFrames(std::vector<scene::KeyFrame> frames);

 private:
  scene::Camera camera() const;
  void flyTo(const scene::Camera& camera, double now_s);
  void play(double now_s);
  void toggleRecording(double now_s);
  void toggleWalk(Gait gait, double now_s);
  void save(std::span<const scene::CameraPath::Key> keys);

  ViewControls& controls_;
  const scene::Ground& ground_;
  GoToPanel goTo_;
  BookmarkPanel bookmarks_;
  KeyFramePanel keyFrames_;
  std::optional<scene::CameraRecorder> recorder_;
  Notify notify_;
};

}  // namespace tellurion::app
