#include "app/follow_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/frame_figures.h"
#include "app/screenshot.h"
#include "app/view_panels.h"

namespace tellurion::app {
namespace {

constexpr std::chrono::milliseconds kPolling{4};     // for data
constexpr std::chrono::milliseconds kAskingGap{30};  // between two wishes for a frame
/// While a frame is waited for: how often the window is looked after.
constexpr std::chrono::milliseconds kReleasePolling{50};

bool isEmpty(scene::Viewport size) {
  return size.width < 1 || size.height < 1;
}

}  // namespace

FollowLoop::FollowLoop(ViewWindow& window, scene::Globe& globe, render::Renderer renderer, io::StepFollower& link,
                       std::string title, const scene::CutOptions& own, FollowedChannel channel,
                       std::optional<FramesLog> log)
    : window_(window),
      globe_(globe),
      renderer_(std::move(renderer)),
      link_(link),
      title_(std::move(title)),
      own_(own),
      channel_(std::move(channel)),
      log_(std::move(log)) {}

io::Result<void> FollowLoop::run() {
  window_.setTitle("(no leader) " + title_);
  window_.appear();
  while (!window_.closing()) {
    for (const InputEvent& event : window_.takeEvents())
      handle(event);
    if (auto fine = tellNews(); !fine) return fine;
    if (isEmpty(window_.pictureSize())) {
      // Nothing to draw on: the leader counts this one as late meanwhile.
    } else if (const auto step = link_.newest()) {
      if (auto done = follow(*step); !done) return done;
    } else if (isStale_) {
      if (auto done = draw(); !done) return done;
      show();
    }
    waitForWork();
  }
  return {};
}

void FollowLoop::handle(const InputEvent& event) {
  if (std::holds_alternative<PictureLost>(event)) isStale_ = true;
  const auto* key = std::get_if<KeyPressed>(&event);
  if (key == nullptr) return;
  if (key->key == ViewKey::quit) window_.close();
  if (key->key == ViewKey::screenshot && target_) saveScreenshot(*target_);
  if (key->key == ViewKey::help || (key->key == ViewKey::escape && helpShown_)) {
    helpShown_ = !helpShown_;
    isStale_ = true;
  }
}

io::Result<void> FollowLoop::tellNews() {
  const auto news = link_.news();
  const auto status = link_.status();
  if (status == io::StepFollower::Status::refused)
    return io::fail(io::Failure::Code::invalidArgument, news.empty() ? state_ : news.back());
  for (const std::string& each : news)
    fmt::print(stderr, "{}\n", each);
  if (news.empty()) return {};
  state_ = news.back();
  isStale_ = isStale_ || helpShown_;
  window_.setTitle((status == io::StepFollower::Status::following ? "" : "(no leader) ") + title_);
  return {};
}

io::Result<void> FollowLoop::follow(const io::StepFollower::Step& step) {
  auto picture = scene::decodeLedPicture(step.state);
  if (!picture) return tl::unexpected(picture.error());
  picture_ = std::move(*picture);
  // Another leader's clock begins elsewhere; that by which data fade in here runs on.
  if (connection_ != step.connection) timeAhead_s_ = cutTime_s_ - picture_->cutTime_s;
  connection_ = step.connection;
  if (auto drawn = draw(); !drawn) return drawn;
  link_.ready(step, isMorphing_);
  const bool isReleased = awaitRelease(step);
  show();
  if (log_) log_->add(step.frame, *shown_, isReleased, isComplete_);
  return {};
}

bool FollowLoop::awaitRelease(const io::StepFollower::Step& step) {
  using Release = io::StepFollower::Release;
  Release release = link_.awaitRelease(step, kReleasePolling);
  while (release == Release::notYet && !window_.closing()) {
    window_.wait(std::chrono::milliseconds(0));
    release = link_.awaitRelease(step, kReleasePolling);
  }
  return release == Release::shown;
}

io::Result<void> FollowLoop::draw() {
  const scene::Viewport size = window_.pictureSize();
  if (!target_ || target_->size().width != size.width || target_->size().height != size.height) {
    target_.reset();
    auto target = render::RenderTarget::create(size);
    if (!target) return tl::unexpected(target.error());
    target_ = std::move(*target);
  }
  if (!picture_) return {};
  auto cut = scene::apply(*picture_, globe_, own_);
  if (!cut) return tl::unexpected(cut.error());
  cutTime_s_ = std::max(cutTime_s_, picture_->cutTime_s + timeAhead_s_);
  cut->time_s = cutTime_s_;
  if (globe_.air().enabled) {
    if (const auto ready = renderer_.prepareAir(); !ready) return ready;
  }
  if (globe_.sky().enabled) {
    if (const auto ready = renderer_.prepareSky(); !ready) return ready;
  }
  const scene::View view = scene::viewOf(*picture_, size);
  const bool isWhole = channel_.all.empty();
  const scene::EyePicture eye = isWhole ? scene::EyePicture{.cut = view, .panes = {}, .warp = {}}
                                        : scene::pictureOf(channel_.all[channel_.which], channel_.all, view, size);
  // Of a channel only its part is copied to the GPU, so what is not there of the rest must not hold back the cut, which
  // is to be that of the other channels.
  const scene::Frame& frame = globe_.update(eye.cut, *cut, isWhole ? &renderer_.residency() : nullptr);
  if (isWhole)
    drawMeasured(renderer_, *target_, frame);
  else
    drawMeasured(renderer_, *target_, scene::partOf(frame, eye.panes.front().view));
  isMorphing_ = frame.morphing || frame.statistics.tilesHeldBack > 0;
  isComplete_ = frame.complete;
  isSettled_ = frame.statistics.tilesWanted == 0 && frame.statistics.layersComing == 0;
  shown_ = scene::ledPicture(globe_, view, *cut);
  shown_->cutTime_s = picture_->cutTime_s;
  const auto& failures = globe_.failures();
  for (; failuresReported_ < failures.size(); ++failuresReported_)
    fmt::print(stderr, "{}\n", io::describe(failures[failuresReported_]));
  return {};
}

void FollowLoop::show() {
  if (picture_) render::copyToWindow(*target_, window_.pictureSize());
  window_.beginPanels();
  if (helpShown_) drawNotice(state_);
  window_.endPanels();
  window_.show();
  isStale_ = false;
}

void FollowLoop::waitForWork() {
  const bool isLoading = picture_ && !isSettled_;
  window_.wait(isLoading ? std::optional(kPolling) : std::nullopt);
  const auto now = Clock::now();
  if (!isLoading || now - lastAsked_ < kAskingGap || !globe_.waitForArrivals(std::chrono::milliseconds(0))) return;
  link_.askForFrame();
  lastAsked_ = now;
}

}  // namespace tellurion::app
