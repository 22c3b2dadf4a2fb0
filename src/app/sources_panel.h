#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "app/server_offers.h"
#include "scene/globe.h"

namespace tellurion::app {

/// What a server offers, asked by its address, and layers of it that are added to the globe. Main thread only; the
/// globe must outlive it.
class SourcesPanel {
 public:
  struct Uses {
    bool offline = false;
    std::function<void()> wake;                    ///< from another thread: draw() has news
    std::function<void(const std::string&)> copy;  ///< to the clipboard
    std::function<void(std::string)> notify;
  };
  SourcesPanel(scene::Globe& globe, Uses uses);

  bool shown() const { return shown_; }
  void toggle();
  /// What is typed is for its field, which is not there yet.
  bool wantsText() const { return shown_ && expectsText_; }
  bool hasNews() const { return shown_ && offers_.hasAnswer(); }
  /// Why nothing can be added; empty: it can.
  void forbid(std::string why) { forbidden_ = std::move(why); }
  /// Between ViewWindow::beginPanels() and endPanels(); nothing while the panel is hidden. True: a layer was added.
  bool draw();

 private:
  void ask();
  void hear();
  void drawAddress();
  void drawList();
  bool drawChosen();
  bool add(const raster::LayerOffer& layer);
  std::string whyNot(const raster::LayerOffer& layer) const;
  void filter();

  scene::Globe& globe_;
  Uses uses_;
  ServerOffers offers_;
  std::string forbidden_;
  bool shown_ = false;
  bool opened_ = false;       ///< since it was last drawn
  bool expectsText_ = false;  ///< since it was opened, and its field does not listen yet
  std::array<char, 2001> address_{};
  std::array<char, 101> sought_{};
  std::string trouble_;  ///< of the last question
  raster::ServiceOffers answer_;
  std::vector<std::string> folded_;  ///< name and title of each of its layers (scene::foldedText)
  std::vector<std::size_t> listed_;  ///< of its layers those that are sought
  std::optional<std::size_t> chosen_;
  bool followsClock_ = false;  ///< what is added shows the time of the scene's clock
};

}  // namespace tellurion::app
