#include "app/sources_panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <utility>

#include "app/scene_entry.h"
#include "raster/map_reference.h"
#include "raster/service_exception.h"
#include "raster/service_url.h"
#include "scene/folded_text.h"

namespace tellurion::app {
namespace {

constexpr float kWidth = 34.0f;        // of a letter's height
constexpr float kRows = 12.0f;         // of the list
constexpr int kDeepest = 8;            // of indents
constexpr std::size_t kLongest = 300;  // of what a server says of a layer

std::string shortened(const std::string& text, std::size_t most) {
  std::string line = raster::onOneLine(text);
  if (line.size() <= most) return line;
  std::size_t end = most;
  while (end > 0 && (static_cast<unsigned char>(line[end]) & 0xC0u) == 0x80u)
    --end;
  return line.substr(0, end) + "...";
}

std::string labelOf(const raster::LayerOffer& layer) {
  const std::string title = shortened(layer.title, 80), name = shortened(layer.name, 60);
  if (layer.name.empty() || title == name) return title.empty() ? name : title;
  return title.empty() ? name : fmt::format("{}   ({})", title, name);
}

/// A heading over others cannot be asked for.
bool isHeading(const raster::ServiceOffers& offers, const raster::LayerOffer& layer) {
  return layer.name.empty() && offers.layers.size() > 1;
}

void drawWrapped(const std::string& text) {
  ImGui::PushTextWrapPos(ImGui::GetFontSize() * kWidth);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
  ImGui::PopTextWrapPos();
}

}  // namespace

SourcesPanel::SourcesPanel(scene::Globe& globe, Uses uses)
    : globe_(globe), uses_(std::move(uses)), offers_(uses_.offline, uses_.wake) {}

void SourcesPanel::toggle() {
  shown_ = !shown_;
  opened_ = expectsText_ = shown_;
}

void SourcesPanel::ask() {
  const std::string_view typed = address_.data();
  const std::size_t first = typed.find_first_not_of(" \t");
  if (first == typed.npos) return;
  answer_ = {};
  chosen_.reset();
  filter();
  trouble_.clear();
  offers_.ask(std::string(typed.substr(first, typed.find_last_not_of(" \t") + 1 - first)));
}

void SourcesPanel::hear() {
  auto answer = offers_.take();
  if (!answer) return;
  if (!*answer) {
    io::Failure failure = std::move(answer->error());
    failure.where = raster::withoutSecrets(failure.where);
    trouble_ = io::describe(failure);
    return;
  }
  answer_ = std::move(**answer);
  folded_.clear();
  for (const raster::LayerOffer& layer : answer_.layers)
    folded_.push_back(scene::foldedText(layer.name + " " + layer.title));
  sought_.fill('\0');
  filter();
  if (answer_.layers.size() == 1) chosen_ = 0;
  if (answer_.layers.empty()) trouble_ = "the server offers no layers";
}

/// What matches, and the headings over it.
void SourcesPanel::filter() {
  listed_.clear();
  const std::string sought = scene::foldedText(sought_.data());
  std::vector<std::size_t> over;
  for (std::size_t i = 0; i < answer_.layers.size(); ++i) {
    const int depth = answer_.layers[i].depth;
    while (!over.empty() && answer_.layers[over.back()].depth >= depth)
      over.pop_back();
    if (folded_[i].find(sought) != std::string::npos) {
      for (const std::size_t heading : over) {
        if (listed_.empty() || listed_.back() < heading) listed_.push_back(heading);
      }
      listed_.push_back(i);
    }
    over.push_back(i);
  }
}

bool SourcesPanel::draw() {
  hear();
  if (!shown_) return false;
  const float unit = ImGui::GetFontSize();
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, unit * 3), ImGuiCond_FirstUseEver, ImVec2(0.5f, 0.0f));
  ImGui::SetNextWindowBgAlpha(0.85f);
  bool isAdded = false;
  if (ImGui::Begin("Layers of a server", &shown_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    drawAddress();
    if (offers_.isAsking()) {
      ImGui::TextUnformatted("asking ...");
    } else if (!trouble_.empty()) {
      drawWrapped(trouble_);
    }
    if (!answer_.layers.empty()) {
      drawList();
      isAdded = drawChosen();
    }
  }
  ImGui::End();
  return isAdded;
}

void SourcesPanel::drawAddress() {
  const float unit = ImGui::GetFontSize();
  if (std::exchange(opened_, false)) {
    ImGui::SetWindowFocus();
    ImGui::SetKeyboardFocusHere();
  }
  ImGui::SetNextItemWidth(unit * (kWidth - 5.0f));
  const bool entered = ImGui::InputTextWithHint(
      "##address", "address of a WMS, WMTS, TMS or of tiles, like https://there/wms", address_.data(), address_.size(),
      ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  if (ImGui::IsItemActive() && ImGui::GetIO().WantTextInput) expectsText_ = false;
  ImGui::SameLine();
  if (ImGui::Button("List", ImVec2(unit * 4.0f, 0.0f)) || entered) ask();
}

void SourcesPanel::drawList() {
  const float unit = ImGui::GetFontSize();
  const std::string of = fmt::format("{} {}", answer_.type, raster::onOneLine(answer_.version));
  drawWrapped(answer_.title.empty() ? of : fmt::format("{}: {}", of, shortened(answer_.title, kLongest)));
  ImGui::SetNextItemWidth(unit * kWidth);
  if (ImGui::InputTextWithHint("##sought", fmt::format("find among {}", answer_.layers.size()).c_str(), sought_.data(),
                               sought_.size()))
    filter();
  const float rows = std::clamp(static_cast<float>(listed_.size()), 1.0f, kRows);
  if (ImGui::BeginChild("##layers", ImVec2(unit * kWidth, ImGui::GetTextLineHeightWithSpacing() * (rows + 1.0f)),
                        true)) {
    ImGuiListClipper clipper;
    clipper.Begin(static_cast<int>(listed_.size()));
    while (clipper.Step()) {
      for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row) {
        const std::size_t index = listed_[static_cast<std::size_t>(row)];
        const raster::LayerOffer& layer = answer_.layers[index];
        ImGui::PushID(static_cast<int>(index));
        const float indent = unit * static_cast<float>(std::min(layer.depth, kDeepest));
        if (indent > 0.0f) ImGui::Indent(indent);
        if (isHeading(answer_, layer)) {
          ImGui::TextDisabled("%s", labelOf(layer).c_str());
        } else if (ImGui::Selectable(labelOf(layer).c_str(), chosen_ == index)) {
          chosen_ = index;
          followsClock_ = !layer.times.empty() && globe_.clock().has_value();
        }
        if (indent > 0.0f) ImGui::Unindent(indent);
        ImGui::PopID();
      }
    }
  }
  ImGui::EndChild();
}

/// Why it cannot be added; empty: it can.
std::string SourcesPanel::whyNot(const raster::LayerOffer& layer) const {
  if (!forbidden_.empty()) return forbidden_;
  if (layer.kind == raster::Kind::elevation) return "these are heights: copy the entry into the scene file";
  const auto body = raster::bodyOfReferences(layer.crs);
  if (body && !(*body == globe_.body()))
    return fmt::format("it lies on {} by its references, this scene on {}", body->name, globe_.body().name);
  return {};
}

/// True: it was added.
bool SourcesPanel::drawChosen() {
  if (!chosen_) return false;
  const raster::LayerOffer& layer = answer_.layers[*chosen_];
  if (!layer.abstract.empty()) drawWrapped(shortened(layer.abstract, kLongest));
  if (!layer.attribution.empty()) drawWrapped(shortened(layer.attribution, kLongest));
  if (layer.box_degrees) {
    const auto& [west, south, east, north] = *layer.box_degrees;
    drawWrapped(fmt::format("from {:.5g}, {:.5g} to {:.5g}, {:.5g}", south, west, north, east));
  }
  if (!layer.times.empty()) {
    ImGui::Checkbox("shows the time of the clock", &followsClock_);
    drawWrapped(shortened("times: " + layer.times, kLongest));
  }
  const std::string why = whyNot(layer);
  bool isAdded = false;
  ImGui::BeginDisabled(!why.empty());
  if (ImGui::Button("Add on top")) isAdded = add(layer);
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (ImGui::Button("Copy its entry")) {
    uses_.copy(tomlOf(layer.entry, layer.kind));
    uses_.notify("copied: paste it into a scene file (docs/scene-file.md)");
  }
  if (!why.empty()) drawWrapped(why);
  return isAdded;
}

bool SourcesPanel::add(const raster::LayerOffer& layer) {
  scene::ImageryLayer added;
  added.name = shortened(layer.title.empty() ? layer.name : layer.title, 80);
  added.source = layer.entry.source;
  added.from = scene::SourceKind::service;
  added.service = layer.entry;
  if (followsClock_ && !layer.times.empty()) added.service.time = scene::kClockTime;
  if (const auto done = globe_.addImagery(added); !done) {
    uses_.notify(io::describe(done.error()));
    return false;
  }
  uses_.notify(fmt::format("{} comes on top as its server answers; I lists the layers", added.name));
  return true;
}

}  // namespace tellurion::app
