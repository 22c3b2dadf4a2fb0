#pragma once

#include <array>
#include <optional>
#include <string>

#include "scene/arrival.h"

namespace tellurion::app {

/// The line that asks where to go: coordinates (scene/parse_place.h) or the name of a place. Main thread only.
class GoToPanel {
 public:
  explicit GoToPanel(scene::Gazetteer places) : places_(std::move(places)) {}

  bool shown() const { return shown_; }
  void open();
  void close() { shown_ = false; }
  /// Between ViewWindow::beginPanels() and endPanels(). The view that was asked for; the panel is then closed.
  std::optional<scene::View> draw(const scene::View& now, const scene::Ground& ground);

 private:
  std::optional<scene::View> drawPlaces(bool entered, const scene::View& now, const scene::Ground& ground);

  scene::Gazetteer places_;
  std::array<char, 201> text_{};
  bool shown_ = false;
  bool opened_ = false;  ///< since it was last drawn
  int chosen_ = 0;       ///< of the places that are listed
};

}  // namespace tellurion::app
