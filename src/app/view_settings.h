#pragma once

#include <array>
#include <functional>
#include <string>

#include "app/frame_figures.h"
#include "app/view_input.h"
#include "render/renderer.h"
#include "scene/globe.h"
#include "scene/quality_control.h"

namespace tellurion::app {

/// How good pictures are (scene::atQuality).
struct ViewQuality {
  double full = 1.0;         ///< of a picture that stands
  bool isAutomatic = false;  ///< while the eye moves it may be lower, so that frames keep to frame_ms
  double frame_ms = 33.0;
  double resolution = 1.0;  ///< scene::resolutionAt full quality
};

/// What the picture is seen in: time, light, air, sky, the height of the relief and the quality, by keys and in a
/// panel. Main thread only; globe and renderer must outlive it.
class ViewSettings {
 public:
  using Notify = std::function<void(std::string)>;
  /// What the last picture was and took.
  struct Cost {
    const FrameFigures& figures;
    scene::Viewport size;
  };

  ViewSettings(scene::Globe& globe, render::Renderer& renderer, const ViewQuality& quality,
               const scene::SceneClock& clock, Notify notify);

  const ViewQuality& quality() const { return quality_; }
  scene::QualityControl& control() { return control_; }
  const scene::QualityControl& control() const { return control_; }
  bool playing() const { return playing_; }
  bool shown() const { return shown_; }
  void show(bool shown) { shown_ = shown; }

  /// True: the picture must be drawn again. Other keys do nothing.
  bool handle(ViewKey key);
  /// Where the clock runs, for so long; at its end it stands.
  void runClock(double seconds);
  /// Between ViewWindow::beginPanels() and endPanels(); nothing while the panel is hidden. True: the picture must be
  /// drawn again.
  bool draw(const Cost& cost);

 private:
  bool drawTime();
  bool drawTimeText();
  bool drawClock();
  bool drawLight();
  bool drawSun();
  bool drawAir();
  bool drawSky();
  bool drawQuality(const Cost& cost);
  bool hasClock();
  bool play();
  bool stepClock(double steps);
  void setTime(double time_s);
  bool toggleAir();
  bool toggleSky();
  void exaggerate(bool more);
  void setGoal();
  void changeQuality(bool finer);
  void toggleAutomaticQuality();

  scene::Globe& globe_;
  render::Renderer& renderer_;
  ViewQuality quality_;
  scene::QualityControl control_;
  scene::SceneClock clock_;  ///< from where it runs on
  bool playing_ = false;
  Notify notify_;
  bool shown_ = false;
  std::array<char, 40> timeText_{};
  bool timeTyped_ = false;  ///< timeText_ is the hand's, not the clock's
};

}  // namespace tellurion::app
