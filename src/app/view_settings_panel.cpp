#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/view_settings.h"
#include "geo/geodetic.h"
#include "geo/sun.h"
#include "raster/time_extent.h"

namespace tellurion::app {
namespace {

constexpr double kHour_s = 3600.0;
constexpr double kMostRate_hours = 1e6;  // a second
constexpr double kMostStops = 20.0;
constexpr double kMostExaggeration = 100.0;
constexpr double kLeastQuality = 0.1;
constexpr double kMostQuality = 10.0;
constexpr double kMostFrame_ms = 200.0;

bool drawSlider(const char* label, double& value, double low, double high, const char* format,
                ImGuiSliderFlags flags = 0) {
  auto v = static_cast<float>(value);
  if (!ImGui::SliderFloat(label, &v, static_cast<float>(low), static_cast<float>(high), format,
                          flags | ImGuiSliderFlags_AlwaysClamp))
    return false;
  value = static_cast<double>(v);
  return true;
}

/// A number that is typed; what is not finite is not taken.
bool drawNumber(const char* label, double& value, double low, double high) {
  double typed = value;
  if (!ImGui::InputDouble(label, &typed, 0.0, 0.0, "%.4g") || !std::isfinite(typed)) return false;
  value = std::clamp(typed, low, high);
  return true;
}

double now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

const char* nameOf(scene::Lighting::Sun sun) {
  switch (sun) {
    case scene::Lighting::Sun::withCamera:
      return "behind the eye";
    case scene::Lighting::Sun::fixed:
      return "above a place";
    case scene::Lighting::Sun::byClock:
      return "by the clock";
  }
  return "";
}

bool section(const char* name) {
  return ImGui::CollapsingHeader(name, ImGuiTreeNodeFlags_DefaultOpen);
}

}  // namespace

bool ViewSettings::draw(const Cost& cost) {
  if (!shown_) return false;
  const float unit = ImGui::GetFontSize();
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(unit * 20, unit / 2), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSizeConstraints(ImVec2(0.0f, 0.0f), ImVec2(window.x, std::max(window.y - 3 * unit, 4 * unit)));
  ImGui::SetNextWindowBgAlpha(0.8f);
  bool changed = false;
  if (ImGui::Begin("View", &shown_, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNav)) {
    ImGui::PushItemWidth(unit * 13);
    if (section("Time")) changed |= drawTime();
    if (section("Light")) changed |= drawLight();
    if (section("Air and sky")) {
      changed |= drawAir();
      changed |= drawSky();
    }
    if (section("Relief"))
      changed |= drawSlider("times as high", globe_.exaggeration(), 0.0, kMostExaggeration, "%.2f",
                            ImGuiSliderFlags_Logarithmic);
    if (section("Quality")) changed |= drawQuality(cost);
    ImGui::PopItemWidth();
  }
  ImGui::End();
  return changed;
}

bool ViewSettings::drawTime() {
  bool changed = drawTimeText();
  ImGui::SameLine();
  if (ImGui::Button("now")) {
    setTime(now_s());
    changed = true;
  }
  ImGui::BeginDisabled(!clock_.start_s.has_value());
  scene::CalendarTime time = scene::calendarTimeOf(clock_.start_s.value_or(0.0));
  bool slid = ImGui::SliderInt("day of the year", &time.day, 1, scene::daysOfYear(time.year), "%d",
                               ImGuiSliderFlags_AlwaysClamp);
  slid |= drawSlider("hour (UTC)", time.hour, 0.0, 24.0, "%.2f");
  if (slid) setTime(scene::secondsOf(time));
  changed |= slid | drawClock();
  ImGui::EndDisabled();
  return changed;
}

/// What is typed counts when Enter ends it; until then the clock does not write over it.
bool ViewSettings::drawTimeText() {
  if (!timeTyped_) {
    timeText_.fill('\0');
    if (clock_.start_s) raster::isoTime(*clock_.start_s).copy(timeText_.data(), timeText_.size() - 1);
  }
  const bool entered =
      ImGui::InputTextWithHint("##time", "2004-01-31T12:00Z", timeText_.data(), timeText_.size(),
                               ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  timeTyped_ = ImGui::IsItemActive();
  if (!entered) return false;
  const auto time_s = raster::secondsOfTime(timeText_.data());
  if (!time_s) {
    notify_(fmt::format("'{}' is no time: write 2004-01-31 or 2004-01-31T12:00:00Z", timeText_.data()));
    return false;
  }
  setTime(*time_s);
  return true;
}

bool ViewSettings::drawClock() {
  bool changed = false;
  if (ImGui::Button(playing_ ? "stop##clock" : "run##clock")) changed |= play();
  ImGui::SameLine();
  if (ImGui::Button("a step back")) changed |= stepClock(-1.0);
  ImGui::SameLine();
  if (ImGui::Button("a step on")) changed |= stepClock(1.0);
  double rate_hours = clock_.rate / kHour_s;
  if (drawNumber("hours a second", rate_hours, -kMostRate_hours, kMostRate_hours)) clock_.rate = rate_hours * kHour_s;
  double step_hours = clock_.step_s / kHour_s;
  if (drawNumber("hours a step", step_hours, 1.0 / kHour_s, kMostRate_hours)) clock_.step_s = step_hours * kHour_s;
  return changed;
}

bool ViewSettings::drawLight() {
  scene::Lighting& light = globe_.lighting();
  bool changed = ImGui::Checkbox("light and shade", &light.enabled);
  ImGui::BeginDisabled(!light.enabled);
  changed |= drawSun();
  changed |= drawSlider("light in the shade", light.ambient, 0.0, 1.0, "%.2f");
  ImGui::EndDisabled();
  return changed;
}

bool ViewSettings::drawSun() {
  using Sun = scene::Lighting::Sun;
  scene::Lighting& light = globe_.lighting();
  bool changed = false;
  const bool isKnown = clock_.start_s && geo::directionToSun(globe_.body(), *clock_.start_s);
  if (ImGui::BeginCombo("sun", nameOf(light.sun))) {
    for (const Sun sun : {Sun::withCamera, Sun::fixed, Sun::byClock}) {
      const bool isPossible = sun != Sun::byClock || isKnown;
      if (!ImGui::Selectable(nameOf(sun), sun == light.sun, isPossible ? 0 : ImGuiSelectableFlags_Disabled)) continue;
      light.sun = sun;
      changed = true;
    }
    ImGui::EndCombo();
  }
  if (light.sun != Sun::fixed) return changed;
  const geo::Vec3& n = light.subsolar.n;
  double lat = std::asin(std::clamp(n.z, -1.0, 1.0)) * 180.0 / geo::kPi;
  double lon = std::atan2(n.y, n.x) * 180.0 / geo::kPi;
  bool moved = drawSlider("its latitude", lat, -90.0, 90.0, "%.1f");
  moved |= drawSlider("its longitude", lon, -180.0, 180.0, "%.1f");
  if (moved) light.subsolar = geo::directionFromDegrees(lat, lon);
  return changed || moved;
}

bool ViewSettings::drawAir() {
  scene::Air& air = globe_.air();
  bool isOn = air.enabled;
  bool changed = ImGui::Checkbox("air", &isOn) && toggleAir();
  ImGui::BeginDisabled(!air.enabled);
  bool isAutomatic = !air.exposure_stops.has_value();
  if (ImGui::Checkbox("automatic exposure", &isAutomatic)) {
    air.exposure_stops = isAutomatic ? std::nullopt : std::optional(0.0);
    changed = true;
  }
  if (air.exposure_stops)
    changed |= drawSlider("exposure, stops", *air.exposure_stops, -kMostStops, kMostStops, "%.1f");
  ImGui::EndDisabled();
  return changed;
}

bool ViewSettings::drawSky() {
  scene::SkySettings& sky = globe_.sky();
  bool isOn = sky.enabled;
  bool changed = ImGui::Checkbox("stars, sun and moon", &isOn) && toggleSky();
  ImGui::BeginDisabled(!sky.enabled);
  changed |= drawSlider("stars, stops", sky.brightness_stops, -kMostStops, kMostStops, "%.1f");
  ImGui::EndDisabled();
  return changed;
}

bool ViewSettings::drawQuality(const Cost& cost) {
  ImGui::Checkbox("coarser while moving, to keep up", &quality_.isAutomatic);
  bool goal = false;
  if (quality_.isAutomatic) goal = drawSlider("ms a frame", quality_.frame_ms, 5.0, kMostFrame_ms, "%.0f");
  goal |=
      drawSlider("quality at rest", quality_.full, kLeastQuality, kMostQuality, "%.2f", ImGuiSliderFlags_Logarithmic);
  if (goal) setGoal();
  const bool resized =
      drawSlider("pixels for one", quality_.resolution, scene::kLeastResolution, scene::kMostResolution, "%.2f");
  const FrameFigures& f = cost.figures;
  ImGui::TextUnformatted(
      fmt::format("{} x {} pixels at quality {:.2f}", cost.size.width, cost.size.height, f.quality).c_str());
  ImGui::TextUnformatted(fmt::format("{} triangles, {:.1f} ms to choose, {:.1f} ms to draw", f.render.triangles,
                                     f.scene.update_ms, f.frame_ms - f.scene.update_ms)
                             .c_str());
  return goal || resized;
}

}  // namespace tellurion::app
