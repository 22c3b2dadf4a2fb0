#include "app/view_panels.h"

#include <imgui.h>

#include <algorithm>
#include <array>

namespace tellurion::app {
namespace {

constexpr ImU32 kBand = IM_COL32(0, 0, 0, 150);
constexpr ImU32 kText = IM_COL32(235, 235, 235, 255);
constexpr float kMargin = 6.0f;
constexpr float kGap = 3.0f * kMargin;
constexpr ImGuiWindowFlags kPanelFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                         ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav;

struct Control {
  const char* input;
  const char* effect;
};

constexpr std::array kControls{
    Control{"Left drag", "pan: the ground stays under the cursor"},
    Control{"Wheel, + and -", "zoom, 10% of the distance a step"},
    Control{"Double click", "fly in where you click"},
    Control{"Right drag, Shift + left drag", "look around"},
    Control{"Middle drag, Ctrl + left drag", "orbit the point under the cursor"},
    Control{"Arrow keys", "pan; Shift: look around; Ctrl: orbit"},
    Control{"T; U", "walk; fly: W A S D, drag, Shift, wheel; or end"},
    Control{"N", "north up"},
    Control{"R, Home; Esc", "fly back to the first view; stop the flight"},
    Control{"G, Ctrl + F", "go to a place: a name or coordinates"},
    Control{"B", "bookmarks of views"},
    Control{"K, J", "add a key frame to a path, show the path"},
    Control{"F9", "record the way of the eye, and save it"},
    Control{"M", "a drag goes on when let go, or not"},
    Control{"V", "time, light, air, sky, relief and quality"},
    Control{"L; O", "light; air (atmosphere), on or off"},
    Control{". and ,", "draw heights higher or lower"},
    Control{"] and [; A", "finer or coarser; coarser while moving, or not"},
    Control{"C, P", "print the camera for --camera, and copy it"},
    Control{"F12", "save the picture as PNG"},
    Control{"1, 2, 3, 4", "show triangles, levels, screen error, boxes"},
    Control{"F", "freeze the cut, or let it follow the eye again"},
    Control{"I; E", "the imagery layers; further ones of a server"},
    Control{"Space, ; and '", "the clock: run or stand, a step back, a step on"},
    Control{"S, F3", "show or hide the statistics"},
    Control{"H, F1; Q", "show or hide this help; quit"},
};

void drawText(float x, float y, const std::string& text) {
  ImGui::GetForegroundDrawList()->AddText(ImVec2(x, y), kText, text.data(), text.data() + text.size());
}

}  // namespace

void drawStatusLine(const std::vector<std::string>& parts, const std::string& right) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float top = size.y - ImGui::GetFontSize() - 2.0f * kMargin;
  const float rightEdge = size.x - kMargin - ImGui::CalcTextSize(right.c_str()).x;
  ImGui::GetForegroundDrawList()->AddRectFilled(ImVec2(0.0f, top), size, kBand);
  drawText(rightEdge, top + kMargin, right);
  float x = kMargin;
  for (const std::string& part : parts) {
    const float end = x + ImGui::CalcTextSize(part.c_str()).x;
    if (end + kGap > rightEdge) break;
    drawText(x, top + kMargin, part);
    x = end + kGap;
  }
}

void drawNotice(const std::string& text) {
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const float x = std::max((ImGui::GetIO().DisplaySize.x - size.x) / 2.0f, kMargin);
  const ImVec2 from(x - 2.0f * kMargin, 2.0f * kMargin);
  const ImVec2 to(x + size.x + 2.0f * kMargin, 4.0f * kMargin + size.y);
  ImGui::GetForegroundDrawList()->AddRectFilled(from, to, kBand, kMargin);
  drawText(x, 3.0f * kMargin, text);
}

void drawStatistics(std::span<const Figure> figures) {
  ImGui::SetNextWindowPos(ImVec2(ImGui::GetIO().DisplaySize.x - kMargin, kMargin), ImGuiCond_Always,
                          ImVec2(1.0f, 0.0f));
  ImGui::SetNextWindowBgAlpha(0.8f);
  ImGui::PushStyleVar(ImGuiStyleVar_CellPadding, ImVec2(kMargin, 1.0f));
  if (ImGui::Begin("Statistics", nullptr, kPanelFlags) &&
      ImGui::BeginTable("statistics", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const Figure& figure : figures) {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(figure.name);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(figure.value.c_str());
    }
    ImGui::EndTable();
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

void drawHelp() {
  const ImVec2 middle(ImGui::GetIO().DisplaySize.x / 2.0f, ImGui::GetIO().DisplaySize.y / 2.0f);
  ImGui::SetNextWindowPos(middle, ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  ImGui::SetNextWindowBgAlpha(0.8f);
  if (ImGui::Begin("Controls", nullptr, kPanelFlags) &&
      ImGui::BeginTable("controls", 2, ImGuiTableFlags_SizingFixedFit)) {
    for (const Control& control : kControls) {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(control.input);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(control.effect);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace tellurion::app
