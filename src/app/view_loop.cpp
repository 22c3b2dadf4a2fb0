#include "app/view_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "app/layers_panel.h"
#include "app/screenshot.h"
#include "app/view_panels.h"
#include "app/view_statistics.h"
#include "raster/time_extent.h"
#include "scene/drawn_ground.h"

namespace tellurion::app {
namespace {

constexpr int kDrawingsOfAnInput = 3;  // ImGui takes a press, a release and a new size one after the other
constexpr int kMostDrawings = 60;      // of clicks that were faster than pictures
constexpr int kMostTyped = 500;        // keys between two pictures: a line that was pasted
constexpr std::chrono::seconds kNoticeTime{4};
/// How often arrivals are looked for while data load, and how often at most they are drawn.
constexpr std::chrono::milliseconds kPolling{4};
constexpr double kArrivalsGap_ms = 50.0;
/// Of the clock by which late data fade in, beyond what the last picture took.
constexpr double kLongestStep_s = 0.05;
constexpr std::chrono::milliseconds kRest{300};  ///< the eye stands when it has not moved for so long
constexpr int kMostRaises = 4;

std::string length(double m) {
  if (std::abs(m) < 10e3) return fmt::format("{:.1f} m", m);
  return fmt::format("{:.{}f} km", m / 1000.0, std::abs(m) < 1000e3 ? 2 : 0);
}

std::string place(const geo::Geodetic& g) {
  const double lat = g.lat.degrees(), lon = geo::wrappedLongitude(g.lon).degrees();
  return fmt::format("{:.5f}\u00b0 {} {:.5f}\u00b0 {}", std::abs(lat), lat < 0 ? 'S' : 'N', std::abs(lon),
                     lon < 0 ? 'W' : 'E');
}

bool isEmpty(scene::Viewport size) {
  return size.width < 1 || size.height < 1;
}

}  // namespace

ViewLoop::ViewLoop(ViewWindow& window, scene::Globe& globe, tiling::Scheme tiling, std::string title,
                   render::Renderer renderer, const scene::View& start, const scene::CutOptions& cut,
                   const ViewQuality& quality, const scene::SceneClock& clock, scene::Gazetteer places, bool offline)
    : window_(window),
      globe_(globe),
      tiling_(tiling),
      title_(std::move(title)),
      renderer_(std::move(renderer)),
      ground_{globe.body().ellipsoid, [&globe](const geo::Direction& d) { return globe.groundHeight_m(d); }},
      controls_(start),
      travel_(controls_, ground_, globe.body().name, std::move(places),
              [this](std::string text) { notify(std::move(text)); }),
      settings_(globe, renderer_, quality, clock, [this](std::string text) { notify(std::move(text)); }),
      sources_(globe, {.offline = offline,
                       .wake = [&window] { window.wake(); },
                       .copy = [&window](const std::string& text) { window.copyToClipboard(text); },
                       .notify = [this](std::string text) { notify(std::move(text)); }}),
      cut_(cut) {
  figures_.quality = quality.full;
}

void ViewLoop::remember(const scene::ViewerMemory& memory) {
  memory_ = memory;
  layersShown_ = memory.layers;
  statisticsShown_ = memory.statistics;
  settings_.show(memory.settings);
  if (layersShown_ || statisticsShown_ || settings_.shown()) showInput();
  if (!memory.hasHint) notify("drag to move, wheel to zoom, right drag to look around; H shows all keys");
  memory_.hasHint = true;
}

scene::ViewerMemory ViewLoop::remembered() const {
  scene::ViewerMemory memory = memory_;
  if (const auto size = window_.ordinarySize()) memory.window = size;
  memory.layers = layersShown_;
  memory.statistics = statisticsShown_;
  memory.settings = settings_.shown();
  return memory;
}

void ViewLoop::lead(Leading& leading) {
  leading_ = &leading;
  sources_.forbid("other windows follow this one, and would not have it: give all of them a scene with its entry");
}

io::Result<void> ViewLoop::run() {
  window_.setTitle("(loading) " + title_);
  window_.appear();
  while (!window_.closing()) {
    for (const InputEvent& event : window_.takeEvents())
      handle(event);
    adjustToWindow();
    if (!isEmpty(window_.pictureSize())) {
      if (pictureDue()) {
        if (auto drawn = drawPicture(); !drawn) return drawn;
      }
      if (panelsStale_) drawPanels();
    }
    waitForWork();
  }
  return {};
}

// Arrivals are followed at once, since each makes the globe ask for finer data; drawing them takes at most a third of
// the time, so that loading goes on at its own pace where the processor draws as well.
bool ViewLoop::pictureDue() const {
  const auto gap = std::chrono::duration<double, std::milli>(std::max(kArrivalsGap_ms, 3.0 * frame_ms_));
  return pictureStale_ || followersWantFrame() || figures_.quality != qualityInForce() ||
         (arrivalsSeen_ && (complete_ || Clock::now() - lastDrawn_ >= gap));
}

bool ViewLoop::isMoving() const {
  return Clock::now() - lastMoved_ < kRest;
}

double ViewLoop::now_s() {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

double ViewLoop::qualityInForce() const {
  return settings_.quality().isAutomatic && isMoving() ? settings_.control().quality() : settings_.quality().full;
}

// Without anything loading, and no notice to take away, the program sleeps until its window hears something.
void ViewLoop::waitForWork() {
  std::optional<std::chrono::milliseconds> atMost;
  const auto waitUpTo = [&atMost](std::chrono::milliseconds time) { atMost = atMost ? std::min(*atMost, time) : time; };
  if (!complete_ || arrivalsSeen_) waitUpTo(kPolling);  // a picture of less than full quality is not complete
  if (noticeDrawn_) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(noticeUntil_ - Clock::now());
    waitUpTo(std::max(left, std::chrono::milliseconds(1)));
  }
  if ((pictureDue() || panelsStale_) && !isEmpty(window_.pictureSize())) atMost = std::chrono::milliseconds(0);
  window_.wait(atMost);
  if (leading_ != nullptr) {
    if (auto news = leading_->tellNews()) notify(std::move(*news));
  }
  if (!complete_ && globe_.waitForArrivals(std::chrono::milliseconds(0))) {
    tellComplete(frameAboveGround());
    arrivalsSeen_ = true;
  }
  if (noticeDrawn_ && !noticeShown()) panelsStale_ = true;
  if (sources_.hasNews()) showInput();
}

void ViewLoop::handle(const InputEvent& event) {
  if (const auto* cursor = std::get_if<CursorMoved>(&event)) cursor_ = cursor->at;
  if (std::holds_alternative<CursorLeft>(event)) cursor_.reset();
  if (const auto* key = std::get_if<KeyPressed>(&event)) handleKey(key->key);
  showInput();
  if (controls_.handle(event, ground_, now_s())) {
    pictureStale_ = true;
    lastMoved_ = Clock::now();
  }
}

void ViewLoop::showInput() {
  panelDrawings_ = std::min(std::max(panelDrawings_ + 2, kDrawingsOfAnInput), kMostDrawings);
  panelsStale_ = true;
}

void ViewLoop::handleKey(ViewKey key) {
  switch (key) {
    case ViewKey::light:
    case ViewKey::air:
    case ViewKey::higher:
    case ViewKey::lower:
    case ViewKey::finer:
    case ViewKey::coarser:
    case ViewKey::automatic:
    case ViewKey::play:
    case ViewKey::earlier:
    case ViewKey::later:
    case ViewKey::settings:
      if (settings_.handle(key)) pictureStale_ = true;
      break;
    case ViewKey::printCamera:
      printCamera();
      break;
    case ViewKey::help:
      helpShown_ = !helpShown_;
      break;
    case ViewKey::escape:
      helpShown_ = false;
      travel_.handle(key, now_s());
      break;
    case ViewKey::screenshot:
      if (target_) notify(saveScreenshot(*target_));
      break;
    case ViewKey::quit:
      window_.close();
      break;
    case ViewKey::wireframe:
      toggleDebugView(scene::DebugView::wireframe);
      break;
    case ViewKey::levels:
      toggleDebugView(scene::DebugView::levels);
      break;
    case ViewKey::error:
      toggleDebugView(scene::DebugView::error);
      break;
    case ViewKey::boxes:
      toggleDebugView(scene::DebugView::boxes);
      break;
    case ViewKey::freeze:
      toggleFrozenCut();
      break;
    case ViewKey::layers:
      layersShown_ = !layersShown_;
      break;
    case ViewKey::sources:
      sources_.toggle();
      break;
    case ViewKey::statistics:
      statisticsShown_ = !statisticsShown_;
      break;
    case ViewKey::goTo:
    case ViewKey::bookmarks:
    case ViewKey::addKeyFrame:
    case ViewKey::keyFrames:
    case ViewKey::record:
    case ViewKey::inertia:
    case ViewKey::walk:
    case ViewKey::fly:
      travel_.handle(key, now_s());
      break;
    case ViewKey::plus:
    case ViewKey::minus:
    case ViewKey::left:
    case ViewKey::right:
    case ViewKey::up:
    case ViewKey::down:
    case ViewKey::north:
    case ViewKey::reset:
      break;
  }
}

void ViewLoop::adjustToWindow() {
  const scene::Viewport size = window_.pictureSize();
  const scene::Viewport& now = controls_.view().viewport;
  if (isEmpty(size) || (target_ && size.width == now.width && size.height == now.height)) return;
  controls_.resize(size);
  target_.reset();
  pictureStale_ = true;
}

scene::View ViewLoop::pictureView() const {
  return scene::atResolution(controls_.view(), scene::resolutionAt(figures_.quality / settings_.quality().full,
                                                                   settings_.quality().resolution));
}

io::Result<void> ViewLoop::prepareTarget(const scene::Viewport& size) {
  if (target_ && target_->size().width == size.width && target_->size().height == size.height) return {};
  target_.reset();  // never two
  auto target = render::RenderTarget::create(size);
  if (!target) return tl::unexpected(target.error());
  target_ = std::move(*target);
  return {};
}

// The ground that is drawn may lie above the finest that is known, while data load or between the samples of a mesh;
// the eye stays above both. Raised, it sees another frame, so this is done again.
const scene::Frame& ViewLoop::frameAboveGround() {
  controls_.keepAboveGround(ground_);
  const scene::CutOptions cut = scene::atQuality(cut_, figures_.quality);
  const scene::Frame* frame = &globe_.update(pictureView(), cut, &renderer_.residency());
  const scene::Ground seen{ground_.ellipsoid, [&](const geo::Direction& d) {
                             const auto known_m = globe_.groundHeight_m(d);
                             const auto drawn_m = scene::drawnHeight_m(*frame, tiling_, ground_.ellipsoid, d);
                             return drawn_m ? std::optional(std::max(*drawn_m, known_m.value_or(*drawn_m))) : known_m;
                           }};
  for (int i = 0; i < kMostRaises; ++i) {
    const geo::BodyPosition before = controls_.view().eye;
    controls_.keepAboveGround(seen);
    if (controls_.view().eye == before) break;
    frame = &globe_.update(pictureView(), cut, &renderer_.residency());
  }
  return *frame;
}

io::Result<void> ViewLoop::drawPicture() {
  const auto begin = Clock::now();
  // A clock that stands while nothing is drawn: what comes after a rest fades in like everything else.
  const double since_s = std::chrono::duration<double>(begin - lastBegun_).count();
  cut_.time_s = cut_.time_s.value_or(0.0) + std::min(since_s, kLongestStep_s + 1e-3 * frame_ms_);
  lastBegun_ = begin;
  settings_.runClock(std::min(since_s, kLongestStep_s + 1e-3 * frame_ms_));
  if (controls_.advance(ground_, std::chrono::duration<double>(begin.time_since_epoch()).count())) lastMoved_ = begin;
  const bool isControlled = settings_.quality().isAutomatic && isMoving();
  const double quality = isControlled ? settings_.control().quality() : settings_.quality().full;
  figures_.quality = quality;
  const scene::Frame& frame = frameAboveGround();
  if (auto ready = prepareTarget(frame.view.viewport); !ready) return ready;
  if (leading_ != nullptr)
    leading_->publish(scene::ledPicture(globe_, controls_.view(), scene::atQuality(cut_, quality)));
  figures_ = drawMeasured(renderer_, *target_, frame);
  figures_.quality = quality;
  lastDrawn_ = Clock::now();
  frame_ms_ = std::chrono::duration<double, std::milli>(lastDrawn_ - begin).count();
  if (isControlled) {
    scene::FrameCost cost = costOf(figures_, std::chrono::duration<double>(lastDrawn_.time_since_epoch()).count());
    cost.cost_ms += waited_ms_;  // what the slowest follower takes beyond this window
    settings_.control().next(cost);
  }
  tellComplete(frame);
  travel_.drawn(now_s());
  pictureStale_ = settings_.playing() || controls_.moving() || frame.unsettled;
  arrivalsSeen_ = false;
  panelsStale_ = true;
  reportFailures();
  return {};
}

/// Whether nothing more will come: all is there and on the GPU, or a budget is spent, at full quality.
void ViewLoop::tellComplete(const scene::Frame& frame) {
  const bool complete = frame.statistics.layersComing == 0 && frame.statistics.tilesWanted == 0 &&
                        frame.statistics.tilesHeldBack == 0 && figures_.quality == settings_.quality().full;
  if (complete != complete_) window_.setTitle(complete ? title_ : "(loading) " + title_);
  complete_ = complete;
}

void ViewLoop::releaseFrame() {
  const auto waited_ms = leading_ != nullptr ? leading_->release(complete_) : std::nullopt;
  if (waited_ms) waited_ms_ = *waited_ms;
}

void ViewLoop::drawPanels() {
  drawPanelsOnce();
  for (int i = 0; i < kMostTyped && window_.hasTyped(); ++i)
    drawPanelsOnce();
  releaseFrame();
  window_.show();
  panelsStale_ = panelsStale_ || window_.hasTyped();
}

void ViewLoop::drawPanelsOnce() {
  render::copyToWindow(*target_, window_.pictureSize());
  window_.beginPanels();
  drawStatusLine(statusParts(), statusRight());
  noticeDrawn_ = noticeShown();
  if (noticeDrawn_) drawNotice(notice_);
  if (statisticsShown_) drawStatistics(statisticsLines(figures_, settings_.quality().isAutomatic));
  if (layersShown_) {
    const LayersDrawn layers = drawLayers(globe_);
    if (layers.changed) pictureStale_ = true;
    if (layers.wantsMore) sources_.toggle();
  }
  if (sources_.draw()) pictureStale_ = true;
  if (settings_.draw({figures_, target_->size()})) pictureStale_ = true;
  if (travel_.draw(now_s())) pictureStale_ = true;
  window_.expectText(travel_.wantsText() || sources_.wantsText());
  window_.expectMotion(controls_.walking() != nullptr);
  if (helpShown_) drawHelp();
  window_.endPanels();
  // ImGui shows a window from its second frame on, when it knows its size.
  if (panelDrawings_ > 0) --panelDrawings_;
  panelsStale_ =
      (helpShown_ && !helpDrawn_) || (statisticsShown_ && !statisticsDrawn_) ||
      ((layersShown_ || sources_.shown() || settings_.shown() || travel_.panelShown()) && panelDrawings_ > 0);
  helpDrawn_ = helpShown_;
  statisticsDrawn_ = statisticsShown_;
}

std::vector<std::string> ViewLoop::statusParts() const {
  const scene::View& view = controls_.view();
  const scene::Camera camera = scene::cameraOf(view, ground_.ellipsoid);
  const double height_m = camera.position.height_m;
  std::vector<std::string> parts{place(camera.position)};
  const auto ground_m = globe_.groundHeight_m(ground_.ellipsoid.directionFromBody(view.eye));
  if (ground_m) parts.push_back(length(height_m - *ground_m) + " above ground");
  parts.push_back("height " + length(height_m));
  const double heading = std::fmod(camera.heading.degrees() + 360.0, 360.0);
  parts.push_back(fmt::format("heading {:.0f}\u00b0 pitch {:.0f}\u00b0", heading, camera.pitch.degrees()));
  if (const auto time_s = globe_.clock()) parts.push_back(raster::isoTime(*time_s));
  const auto under = cursor_ && !controls_.dragging() ? scene::pointUnder(view, *cursor_, ground_) : std::nullopt;
  if (under) {
    const geo::Geodetic g = ground_.ellipsoid.geodeticFromBody(*under);
    parts.push_back(fmt::format("cursor {} {}", place(g), length(g.height_m)));
  }
  return parts;
}

std::string ViewLoop::statusRight() const {
  std::string text = fmt::format("{:.0f} ms", frame_ms_);
  const int missing = figures_.scene.tilesWanted + figures_.scene.tilesHeldBack;
  if (!complete_ && missing > 0) text = fmt::format("loading {} tiles   ", missing) + text;
  const std::size_t failures = globe_.failures().size();
  if (failures > 0) text = fmt::format("{} not loaded   ", failures) + text;
  if (figures_.scene.layersComing > 0)
    text =
        fmt::format("{} layer{} to come   ", figures_.scene.layersComing, figures_.scene.layersComing == 1 ? "" : "s") +
        text;
  if (const auto troubles = globe_.troubles(); !troubles.empty()) text = io::describe(troubles.front()) + "   " + text;
  if (globe_.cutIsFrozen()) text = "cut frozen   " + text;
  if (leading_ != nullptr) text = leading_->status() + "   " + text;
  if (controls_.walking() != nullptr) text = controls_.walking()->status() + "   " + text;
  if (travel_.recording()) text = "recording   " + text;
  return text + "   H: help";
}

/// The first time their shaders are compiled.
bool ViewLoop::readyForDebugViews() {
  const auto ready = renderer_.prepareDebugViews();
  if (!ready) notify(io::describe(ready.error()));
  return ready.has_value();
}

void ViewLoop::toggleDebugView(scene::DebugView view) {
  if (!readyForDebugViews()) return;
  globe_.debugViews().toggle(view);
  pictureStale_ = true;
}

void ViewLoop::toggleFrozenCut() {
  if (!readyForDebugViews()) return;
  globe_.freezeCut(globe_.cutIsFrozen() ? std::nullopt : std::optional(controls_.view()));
  notify(globe_.cutIsFrozen() ? "the cut is frozen: it stays while the eye moves on, F lets it follow again"
                              : "the cut follows the eye again");
  pictureStale_ = true;
}

void ViewLoop::printCamera() {
  const std::string line = scene::formatCamera(scene::cameraOf(controls_.view(), ground_.ellipsoid));
  fmt::print("{}\n", line);
  std::fflush(stdout);
  window_.copyToClipboard(line);
  notify("camera printed and copied: " + line);
}

void ViewLoop::reportFailures() {
  const auto& failures = globe_.failures();
  for (; failuresReported_ < failures.size(); ++failuresReported_)
    fmt::print(stderr, "{}\n", io::describe(failures[failuresReported_]));
}

void ViewLoop::notify(std::string text) {
  notice_ = std::move(text);
  noticeUntil_ = Clock::now() + kNoticeTime;
  panelsStale_ = true;
}

}  // namespace tellurion::app
