#include "app/layers_panel.h"

#include <imgui.h>

#include <optional>

namespace tellurion::app {
namespace {

constexpr float kMargin = 6.0f;

bool drawSlider(const char* label, double& value, double low, double high) {
  auto v = static_cast<float>(value);
  if (!ImGui::SliderFloat(label, &v, static_cast<float>(low), static_cast<float>(high), "%.2f")) return false;
  value = static_cast<double>(v);
  return true;
}

bool drawBlendMode(scene::BlendMode& blend) {
  bool changed = false;
  if (!ImGui::BeginCombo("blend", scene::nameOf(blend))) return false;
  for (const scene::BlendMode mode : scene::kBlendModes) {
    if (!ImGui::Selectable(scene::nameOf(mode), mode == blend)) continue;
    blend = mode;
    changed = true;
  }
  ImGui::EndCombo();
  return changed;
}

/// Night lights and water have no colour of their own, and nothing to blend with.
bool drawLook(scene::LayerLook& look) {
  constexpr double kMost = 3.0;  // more is for scene files
  bool changed = drawSlider("opacity", look.opacity, 0.0, 1.0);
  changed |= drawSlider("brightness", look.brightness, 0.0, kMost);
  if (look.role != scene::LayerRole::colour) return changed;
  changed |= drawSlider("contrast", look.contrast, 0.0, kMost);
  changed |= drawSlider("saturation", look.saturation, 0.0, kMost);
  changed |= drawSlider("gamma", look.gamma, scene::kLeastGamma, kMost);
  changed |= drawBlendMode(look.blend);
  return changed;
}

struct Move {
  std::size_t layer = 0;
  std::size_t place = 0;
};

/// Up and down; where the layer at this place shall go. The arrow that leads nowhere is there too, so that all names
/// begin below each other.
std::optional<std::size_t> drawArrows(std::size_t place, std::size_t count) {
  std::optional<std::size_t> to;
  ImGui::SameLine();
  ImGui::BeginDisabled(place + 1 == count);
  if (ImGui::ArrowButton("##up", ImGuiDir_Up)) to = place + 1;
  ImGui::EndDisabled();
  ImGui::SameLine(0.0f, 1.0f);
  ImGui::BeginDisabled(place == 0);
  if (ImGui::ArrowButton("##down", ImGuiDir_Down)) to = place - 1;
  ImGui::EndDisabled();
  return to;
}

}  // namespace

LayersDrawn drawLayers(scene::Globe& globe) {
  bool changed = false, wantsMore = false;
  ImGui::SetNextWindowPos(ImVec2(kMargin, kMargin), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowBgAlpha(0.8f);
  if (ImGui::Begin("Layers", nullptr, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    const std::span<const std::uint32_t> order = globe.imageryOrder();
    std::optional<Move> move;
    for (std::size_t place = order.size(); place-- > 0;) {
      scene::LayerLook& look = globe.imageryLooks()[order[place]];
      ImGui::PushID(static_cast<int>(order[place]));
      changed |= ImGui::Checkbox("##visible", &look.visible);
      if (const auto to = drawArrows(place, order.size())) move = Move{.layer = order[place], .place = *to};
      ImGui::SameLine();
      if (ImGui::TreeNode(globe.imageryNames()[order[place]].c_str())) {
        ImGui::PushItemWidth(ImGui::GetFontSize() * 10.0f);
        changed |= drawLook(look);
        ImGui::PopItemWidth();
        ImGui::TreePop();
      }
      ImGui::PopID();
    }
    if (move) globe.moveImagery(move->layer, move->place);
    changed |= move.has_value();
    wantsMore = ImGui::Button("Add from a server");
  }
  ImGui::End();
  return {.changed = changed, .wantsMore = wantsMore};
}

}  // namespace tellurion::app
