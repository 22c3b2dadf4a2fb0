#include "app/view_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

// What keys do; what the panel does stands in view_settings_panel.cpp.
namespace tellurion::app {
namespace {

/// The value next to this one; itself at the ends.
template <std::size_t N>
double steppedFrom(double value, bool up, const std::array<double, N>& steps) {
  const auto* next = up ? std::ranges::upper_bound(steps, value) : std::ranges::lower_bound(steps, value);
  if (up) return next != steps.end() ? *next : value;
  return next != steps.begin() ? *(next - 1) : value;
}

}  // namespace

ViewSettings::ViewSettings(scene::Globe& globe, render::Renderer& renderer, const ViewQuality& quality,
                           const scene::SceneClock& clock, Notify notify)
    : globe_(globe),
      renderer_(renderer),
      quality_(quality),
      control_({.frame_ms = quality.frame_ms, .ceiling = quality.full}),
      clock_(clock),
      notify_(std::move(notify)) {}

bool ViewSettings::handle(ViewKey key) {
  if (key == ViewKey::settings) shown_ = !shown_;
  if (key == ViewKey::light) globe_.lighting().enabled = !globe_.lighting().enabled;
  if (key == ViewKey::higher || key == ViewKey::lower) exaggerate(key == ViewKey::higher);
  if (key == ViewKey::finer || key == ViewKey::coarser) changeQuality(key == ViewKey::finer);
  if (key == ViewKey::automatic) toggleAutomaticQuality();
  if (key == ViewKey::air) return toggleAir();
  if (key == ViewKey::play) return play();
  if (key == ViewKey::earlier || key == ViewKey::later) return stepClock(key == ViewKey::later ? 1.0 : -1.0);
  return key == ViewKey::light || key == ViewKey::higher || key == ViewKey::lower;
}

void ViewSettings::runClock(double seconds) {
  if (!playing_) return;
  const double before_s = *clock_.start_s;
  clock_.start_s = scene::timeAfter(clock_, seconds);
  playing_ = *clock_.start_s != before_s || clock_.rate == 0.0;
  globe_.setClock(*clock_.start_s);
}

bool ViewSettings::hasClock() {
  if (!clock_.start_s)
    notify_(
        "there is no time to begin with: give one in the panel (V), or the scene a [clock] with a start, or --time");
  return clock_.start_s.has_value();
}

bool ViewSettings::play() {
  if (!hasClock()) return false;
  playing_ = !playing_;
  notify_(playing_ ? fmt::format("the clock runs: {:g} days a second", clock_.rate / 86400.0) : "the clock stands");
  return true;
}

bool ViewSettings::stepClock(double steps) {
  if (!hasClock()) return false;
  playing_ = false;
  setTime(*clock_.start_s + steps * clock_.step_s);
  return true;
}

void ViewSettings::setTime(double time_s) {
  clock_.start_s = time_s;
  globe_.setClock(time_s);
}

/// Where the scene says nothing of its air, that of its body.
bool ViewSettings::toggleAir() {
  scene::Air& air = globe_.air();
  if (!scene::knowAir(air, globe_.body().name)) {
    notify_("the air of this body is not known: describe it in the scene's [atmosphere]");
    return false;
  }
  if (const auto ready = renderer_.prepareAir(); !ready) {
    notify_(io::describe(ready.error()));
    return false;
  }
  air.enabled = !air.enabled;
  return true;
}

bool ViewSettings::toggleSky() {
  if (const auto ready = renderer_.prepareSky(); !ready) {
    notify_(io::describe(ready.error()));
    return false;
  }
  globe_.sky().enabled = !globe_.sky().enabled;
  return true;
}

void ViewSettings::exaggerate(bool more) {
  constexpr std::array kSteps{0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0};
  double& exaggeration = globe_.exaggeration();
  exaggeration = steppedFrom(exaggeration, more, kSteps);
  notify_(fmt::format("heights are drawn {} times as high", exaggeration));
}

void ViewSettings::setGoal() {
  control_.setGoal({.frame_ms = quality_.frame_ms, .ceiling = quality_.full});
}

void ViewSettings::changeQuality(bool finer) {
  constexpr std::array kSteps{0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0};
  quality_.full = steppedFrom(quality_.full, finer, kSteps);
  setGoal();
  notify_(fmt::format("quality {}{}", quality_.full, quality_.isAutomatic ? " at rest" : ""));
}

void ViewSettings::toggleAutomaticQuality() {
  quality_.isAutomatic = !quality_.isAutomatic;
  notify_(quality_.isAutomatic
              ? fmt::format("automatic: quality falls while moving, where frames take over {} ms", quality_.frame_ms)
              : fmt::format("quality stays at {}", quality_.full));
}

}  // namespace tellurion::app
