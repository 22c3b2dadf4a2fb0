#pragma once

#include <chrono>
#include <string>

#include "app/frame_figures.h"
#include "app/leading.h"
#include "app/sources_panel.h"
#include "app/view_controls.h"
#include "app/view_settings.h"
#include "app/view_travel.h"
#include "app/view_window.h"
#include "render/renderer.h"
#include "scene/globe.h"

namespace tellurion::app {

/// The viewer while its window is open: hands input to the controls, draws when something has changed, sleeps else.
/// Main thread only. Window and globe must outlive it.
class ViewLoop {
 public:
  ViewLoop(ViewWindow& window, scene::Globe& globe, tiling::Scheme tiling, std::string title, render::Renderer renderer,
           const scene::View& start, const scene::CutOptions& cut, const ViewQuality& quality,
           const scene::SceneClock& clock, scene::Gazetteer places, bool offline);

  /// Where the eye can be sent.
  ViewTravel& travel() { return travel_; }

  /// Does as it did when it was closed last.
  void remember(const scene::ViewerMemory& memory);
  /// What to remember of it, beside what was remembered before.
  scene::ViewerMemory remembered() const;

  /// Has others follow; it must outlive this.
  void lead(Leading& leading);

  /// Until the window is closed. Fails when the picture cannot be drawn.
  io::Result<void> run();

 private:
  using Clock = std::chrono::steady_clock;

  bool pictureDue() const;
  bool isMoving() const;
  double qualityInForce() const;
  static double now_s();  ///< of the clock by which the eye moves
  void waitForWork();
  void handle(const InputEvent& event);
  void showInput();
  void handleKey(ViewKey key);
  void adjustToWindow();
  io::Result<void> drawPicture();
  io::Result<void> prepareTarget(const scene::Viewport& size);
  void releaseFrame();
  bool followersWantFrame() const { return leading_ != nullptr && leading_->wantsFrame(); }
  scene::View pictureView() const;
  const scene::Frame& frameAboveGround();
  void drawPanels();
  void drawPanelsOnce();
  void tellComplete(const scene::Frame& frame);
  void toggleDebugView(scene::DebugView view);
  void toggleFrozenCut();
  bool readyForDebugViews();
  void printCamera();
  void reportFailures();
  void notify(std::string text);
  bool noticeShown() const { return Clock::now() < noticeUntil_; }
  std::vector<std::string> statusParts() const;
  std::string statusRight() const;

  ViewWindow& window_;
  scene::Globe& globe_;
  tiling::Tiling tiling_;
  std::string title_;
  render::Renderer renderer_;
  scene::Ground ground_;
  ViewControls controls_;
  ViewTravel travel_;
  ViewSettings settings_;
  SourcesPanel sources_;
  scene::ViewerMemory memory_;  ///< as it was given
  scene::CutOptions cut_;       ///< at quality 1
  Leading* leading_ = nullptr;  ///< null: nobody follows
  double waited_ms_ = 0.0;      ///< in the last frame, for followers
  std::optional<render::RenderTarget> target_;
  std::optional<scene::PixelPosition> cursor_;
  bool pictureStale_ = true;   ///< the planet must be drawn again
  bool arrivalsSeen_ = false;  ///< the globe has more to show than what is drawn
  bool panelsStale_ = true;    ///< what lies over it must
  bool complete_ = false;
  bool helpShown_ = false;
  bool helpDrawn_ = false;
  bool statisticsShown_ = false;
  bool layersShown_ = false;
  int panelDrawings_ = 0;  ///< that panels need until they show what the last input has done
  bool statisticsDrawn_ = false;
  FrameFigures figures_;  ///< of the last picture
  double frame_ms_ = 0.0;
  std::size_t failuresReported_ = 0;
  std::string notice_;
  bool noticeDrawn_ = false;
  Clock::time_point noticeUntil_{};
  Clock::time_point lastDrawn_{};
  Clock::time_point lastBegun_{};  ///< when the last picture was begun
  Clock::time_point lastMoved_{};  ///< when the hand last moved the eye
};

}  // namespace tellurion::app
