#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene/bookmarks.h"

namespace tellurion::app {

/// Views with names: kept, listed, flown to, deleted, and remembered between runs in bookmarks.toml (config_file.h).
/// Each change reads the file first, so that two viewers do not lose each other's. Main thread only.
class BookmarkPanel {
 public:
  using Notify = std::function<void(std::string)>;
  BookmarkPanel(std::string body, Notify notify) : body_(std::move(body)), notify_(std::move(notify)) {}

  bool& shown() { return shown_; }
  /// Between ViewWindow::beginPanels() and endPanels(). The camera that was asked for; `now`: what "Save" keeps.
  std::optional<scene::Camera> draw(const scene::Camera& now);

 private:
  /// What the file has; one that is damaged is told and set aside.
  std::vector<scene::Bookmark> load();
  void change(const std::function<void(std::vector<scene::Bookmark>&)>& what);

  std::string body_;
  Notify notify_;
  std::vector<scene::Bookmark> bookmarks_;  ///< as the file was when it was last read
  std::array<char, 128> name_{};
  bool shown_ = false;
  bool loaded_ = false;
};

}  // namespace tellurion::app
