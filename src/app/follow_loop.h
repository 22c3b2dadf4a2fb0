#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "app/frames_log.h"
#include "app/view_window.h"
#include "io/step_follower.h"
#include "render/renderer.h"
#include "scene/globe.h"
#include "scene/projector_channels.h"

namespace tellurion::app {

/// What of a leader's surroundings a window shows.
struct FollowedChannel {
  std::vector<scene::ProjectorChannel> all;  ///< empty: what the leader's window shows
  std::size_t which = 0;
};

/// A window that shows what another one does, while it is open: each of the leader's frames is drawn when it comes and
/// shown when it is released. Its hand does nothing but quit, show where it stands (F1) and take pictures of it (F12).
/// Main thread only. All that it is given must outlive it.
class FollowLoop {
 public:
  FollowLoop(ViewWindow& window, scene::Globe& globe, render::Renderer renderer, io::StepFollower& link,
             std::string title, const scene::CutOptions& own, FollowedChannel channel, std::optional<FramesLog> log);

  /// Until the window is closed. Fails when the leader refuses, shows another scene, or the picture cannot be drawn.
  io::Result<void> run();

 private:
  using Clock = std::chrono::steady_clock;

  void handle(const InputEvent& event);
  io::Result<void> tellNews();
  io::Result<void> follow(const io::StepFollower::Step& step);
  bool awaitRelease(const io::StepFollower::Step& step);
  io::Result<void> draw();
  void show();
  void waitForWork();

  ViewWindow& window_;
  scene::Globe& globe_;
  render::Renderer renderer_;
  io::StepFollower& link_;
  std::string title_;
  scene::CutOptions own_;  ///< of its budgets
  FollowedChannel channel_;
  std::optional<FramesLog> log_;
  std::optional<render::RenderTarget> target_;
  std::optional<scene::LedPicture> picture_;  ///< the last that the leader gave
  std::optional<scene::LedPicture> shown_;    ///< what was made of it
  std::uint64_t connection_ = 0;              ///< by which it came
  double timeAhead_s_ = 0.0;                  ///< what this window's fading clock is ahead of this leader's
  double cutTime_s_ = 0.0;
  bool isStale_ = false;     ///< the window must be drawn again, with what it shows
  bool isMorphing_ = false;  ///< the last frame's picture changes with time
  bool isComplete_ = false;
  bool isSettled_ = false;  ///< no more data are waited for
  bool helpShown_ = false;
  std::string state_ = "no leader yet";
  std::size_t failuresReported_ = 0;
  Clock::time_point lastAsked_{};
};

}  // namespace tellurion::app
