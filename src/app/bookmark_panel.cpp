#include "app/bookmark_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include "app/config_file.h"

namespace tellurion::app {
namespace {

constexpr std::string_view kFile = "bookmarks.toml";

std::string nameFor(const scene::Camera& camera) {
  return fmt::format("{:.3f}, {:.3f}", camera.position.lat.degrees(),
                     geo::wrappedLongitude(camera.position.lon).degrees());
}

}  // namespace

std::vector<scene::Bookmark> BookmarkPanel::load() {
  const auto text = readConfig(kFile);
  if (!text) {
    notify_(io::describe(text.error()));
    return {};
  }
  if (!*text) return {};
  auto read = scene::parseBookmarks(**text, configPath(kFile));
  if (read) return std::move(*read);
  notify_(fmt::format("{}; the bookmarks are kept as {}", io::describe(read.error()), setAsideConfig(kFile)));
  return {};
}

void BookmarkPanel::change(const std::function<void(std::vector<scene::Bookmark>&)>& what) {
  if (const auto readable = readConfig(kFile); !readable) {
    notify_("not saved: " + io::describe(readable.error()));
    return;
  }
  bookmarks_ = load();
  what(bookmarks_);
  const auto written = writeConfig(kFile, scene::formatBookmarks(bookmarks_));
  if (!written) notify_("not saved: " + io::describe(written.error()));
}

std::optional<scene::Camera> BookmarkPanel::draw(const scene::Camera& now) {
  if (!loaded_) bookmarks_ = load();
  loaded_ = true;
  std::optional<scene::Camera> asked;
  std::optional<std::size_t> deleted;
  const float unit = ImGui::GetFontSize();
  ImGui::SetNextWindowPos(ImVec2(unit / 2, unit * 4), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.8f);
  if (ImGui::Begin("Bookmarks", &shown_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    ImGui::SetNextItemWidth(unit * 16);
    const bool entered = ImGui::InputTextWithHint("##name", "name of this view", name_.data(), name_.size(),
                                                  ImGuiInputTextFlags_EnterReturnsTrue);
    ImGui::SameLine();
    if (ImGui::Button("Save") || entered) {
      const std::string name = name_[0] != '\0' ? std::string(name_.data()) : nameFor(now);
      change([&](auto& all) { all.push_back({.name = name, .body = body_, .camera = now}); });
      name_.fill('\0');
      notify_("bookmark '" + name + "' saved");
    }
    for (std::size_t i = 0; i < bookmarks_.size(); ++i) {
      if (bookmarks_[i].body != body_) continue;
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::SmallButton("x")) deleted = i;
      ImGui::SameLine();
      if (ImGui::Selectable(bookmarks_[i].name.empty() ? "(no name)" : bookmarks_[i].name.c_str()))
        asked = bookmarks_[i].camera;
      ImGui::PopID();
    }
  }
  ImGui::End();
  if (deleted) {
    const scene::Bookmark gone = bookmarks_[*deleted];
    change([&gone](auto& all) {
      for (auto at = all.begin(); at != all.end(); ++at) {
        if (at->name != gone.name || scene::formatCamera(at->camera) != scene::formatCamera(gone.camera)) continue;
        all.erase(at);
        return;
      }
    });
  }
  return asked;
}

}  // namespace tellurion::app
