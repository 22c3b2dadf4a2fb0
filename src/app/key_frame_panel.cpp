#include "app/key_frame_panel.h"

#include <fmt/format.h>
#include <imgui.h>

namespace tellurion::app {
namespace {

std::string labelOf(std::size_t i, const scene::Camera& camera) {
  return fmt::format("{}: {:.3f}, {:.3f}, {:.1f} km", i + 1, camera.position.lat.degrees(),
                     geo::wrappedLongitude(camera.position.lon).degrees(), camera.position.height_m / 1000.0);
}

bool drawArrow(const char* name, ImGuiDir direction, bool enabled) {
  ImGui::BeginDisabled(!enabled);
  const bool pressed = ImGui::ArrowButton(name, direction);
  ImGui::EndDisabled();
  ImGui::SameLine(0.0f, 1.0f);
  return pressed;
}

}  // namespace

void KeyFramePanel::drawFrame(std::size_t i, Asked& asked) {
  scene::KeyFrame& frame = frames_[i];
  ImGui::TableNextColumn();
  if (drawArrow("##up", ImGuiDir_Up, i > 0)) moved_ = {i, i - 1};
  if (drawArrow("##down", ImGuiDir_Down, i + 1 < frames_.size())) moved_ = {i, i + 1};
  if (ImGui::SmallButton("x")) deleted_ = i;
  ImGui::TableNextColumn();
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 6);
  if (i > 0) ImGui::InputDouble("##leg", &frame.leg_s, 0.0, 0.0, "%.2f s");
  ImGui::TableNextColumn();
  if (ImGui::Selectable(labelOf(i, frame.camera).c_str(), false, 0,
                        ImVec2(ImGui::CalcTextSize(labelOf(i, frame.camera).c_str()).x, 0.0f)))
    asked = frame.camera;
}

KeyFramePanel::Asked KeyFramePanel::draw(const scene::Camera& now) {
  Asked asked;
  const float unit = ImGui::GetFontSize();
  ImGui::SetNextWindowPos(ImVec2(unit / 2, unit * 14), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.8f);
  if (ImGui::Begin("Key frames", &shown_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    if (ImGui::Button("Add this view")) frames_.push_back({.camera = now});
    ImGui::SameLine();
    ImGui::BeginDisabled(frames_.empty());
    if (ImGui::Button("Play")) asked = Play{};
    ImGui::SameLine();
    if (ImGui::Button("Save")) asked = Save{};
    ImGui::EndDisabled();
    if (frames_.empty()) ImGui::TextUnformatted("K adds a view to the path");
    if (!frames_.empty() && ImGui::BeginTable("frames", 3, ImGuiTableFlags_SizingFixedFit)) {
      for (std::size_t i = 0; i < frames_.size(); ++i) {
        ImGui::PushID(static_cast<int>(i));
        drawFrame(i, asked);
        ImGui::PopID();
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
  if (moved_) scene::moveKeyFrame(frames_, moved_->first, moved_->second);
  if (deleted_) frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(*deleted_));
  moved_.reset();
  deleted_.reset();
  return asked;
}

}  // namespace tellurion::app
