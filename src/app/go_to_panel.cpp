#include "app/go_to_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>

namespace tellurion::app {
namespace {

constexpr std::size_t kMostListed = 12;

std::string labelOf(const scene::Place& place) {
  std::string label = place.name;
  if (!place.kind.empty()) label += ", " + place.kind;
  label += fmt::format("   {:.2f}, {:.2f}", place.lat.degrees(), place.lon.degrees());
  if (place.size_m > 0.0) label += fmt::format("   {:.0f} km", place.size_m / 1000.0);
  return label;
}

}  // namespace

void GoToPanel::open() {
  shown_ = opened_ = true;
  text_.fill('\0');
  chosen_ = 0;
}

std::optional<scene::View> GoToPanel::draw(const scene::View& now, const scene::Ground& ground) {
  std::optional<scene::View> asked;
  const float unit = ImGui::GetFontSize();
  ImGui::SetNextWindowPos(ImVec2(ImGui::GetIO().DisplaySize.x / 2, unit * 3), ImGuiCond_Always, ImVec2(0.5f, 0.0f));
  ImGui::SetNextWindowBgAlpha(0.85f);
  if (ImGui::Begin("Go to", &shown_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    if (std::exchange(opened_, false)) {
      ImGui::SetWindowFocus();
      ImGui::SetKeyboardFocusHere();
    }
    ImGui::SetNextItemWidth(unit * 28);
    const bool entered = ImGui::InputTextWithHint(
        "##where", "a name, or coordinates: 27.988, 86.925   27\302\26059'17\"N 86\302\26055'30\"E", text_.data(),
        text_.size(), ImGuiInputTextFlags_EnterReturnsTrue);
    if (entered) ImGui::SetKeyboardFocusHere(-1);  // Enter left the field; what was not found is written anew
    if (ImGui::IsItemEdited()) chosen_ = 0;
    if (text_[0] != '\0') {
      const auto written = scene::parsePlace(text_.data());
      if (written) {
        const geo::Geodetic& p = written->camera.position;
        const std::string label = fmt::format("{:.6f}, {:.6f}{}", p.lat.degrees(), p.lon.degrees(),
                                              written->hasHeight ? fmt::format(", {:.1f} m", p.height_m) : "");
        if (ImGui::Selectable(label.c_str(), true) || entered) asked = scene::arrivalAt(*written, now, ground);
      } else {
        asked = drawPlaces(entered, now, ground);
      }
    }
  }
  ImGui::End();
  if (asked) close();
  return asked;
}

std::optional<scene::View> GoToPanel::drawPlaces(bool entered, const scene::View& now, const scene::Ground& ground) {
  std::optional<scene::View> asked;
  const auto found = places_.search(text_.data(), kMostListed);
  if (found.empty()) {
    const auto written = scene::parsePlace(text_.data());
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 28);
    ImGui::TextUnformatted(places_.empty() ? "no list of places is known for this body (--places FILE)"
                                           : "no such place in the list");
    if (!written) ImGui::TextUnformatted(written.error().message.c_str());
    ImGui::PopTextWrapPos();
    return asked;
  }
  const int last = static_cast<int>(found.size()) - 1;
  if (ImGui::IsKeyPressed(ImGuiKey_DownArrow)) ++chosen_;
  if (ImGui::IsKeyPressed(ImGuiKey_UpArrow)) --chosen_;
  chosen_ = std::clamp(chosen_, 0, last);
  for (int i = 0; i <= last; ++i) {
    const scene::Place& place = *found[static_cast<std::size_t>(i)];
    ImGui::PushID(i);
    if (ImGui::Selectable(labelOf(place).c_str(), i == chosen_) || (entered && i == chosen_))
      asked = scene::arrivalAt(place, now, ground);
    ImGui::PopID();
  }
  return asked;
}

}  // namespace tellurion::app
