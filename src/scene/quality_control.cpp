#include "scene/quality_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr double kRungsAnOctave = 4.0;
constexpr int kMostRungs = 64;

/// A level of tiles takes this long to fade; until then frames cost what they did.
constexpr double kFade_s = CutOptions{}.fade_s;
constexpr double kLongestGap_s = 0.5;

/// What is plain is told from few frames, soon: far over its time, or far under it. The rest by a long look.
constexpr double kFarOver = 1.35;
constexpr double kFarUnder = 0.6;
constexpr double kRoom = 0.9;  ///< under this part of its time there is room
constexpr double kShortLook_s = 0.3;
constexpr double kLongLook_s = 2.5;
constexpr double kLongEnough_s = 2.0;
constexpr std::size_t kFewestFrames = 3;
constexpr double kFewFrames_s = 0.5;  ///< long enough for the fewest
constexpr std::size_t kSomeFrames = 5;
/// A few slow frames fill a short look: so many are looked at, but no older than this.
constexpr std::size_t kManyFrames = 9;
constexpr double kNotSoShortLook_s = 1.5;
constexpr double kBetweenLooks_s = 0.04;

constexpr int kMostDown = 8;
constexpr int kMostUp = 4;
/// Going up, cost is taken to grow faster than it mostly does; going down, to fall in proportion.
constexpr double kCostExponentUp = 1.5;

constexpr double kFirstPause_s = 8.0;
constexpr double kLongestPause_s = 300.0;
constexpr double kProven_s = 60.0;  ///< a quality that was held for so long is not too dear after all
/// Costs under these parts of what they were say that the load has fallen: of the same quality, of the next higher one.
constexpr double kFallenOfSame = 0.8;
constexpr double kFallenOfNext = 0.5;

/// How many rungs a ratio of qualities is.
double rungsOf(double ratio) {
  return kRungsAnOctave * std::log2(ratio);
}

}  // namespace

CutOptions atQuality(CutOptions cut, double quality) {
  cut.tolerance_px /= quality;
  cut.maxSpacing_px /= quality;
  cut.texelTolerance_px *= std::max(1.0, 1.0 / quality);
  return cut;
}

double resolutionAt(double share, double full) {
  return std::max(kLeastResolution, full * std::clamp(2.0 * share, 0.5, 1.0));
}

View atResolution(View view, double resolution) {
  if (resolution == 1.0) return view;
  view.agreedPixelAngle = view.pixelAngle();
  view.offAxis = view.sides();  // whole numbers of pixels are of another shape: the picture is not
  for (int* side : {&view.viewport.width, &view.viewport.height})
    *side = std::max(1, static_cast<int>(std::lround(*side * resolution)));
  return view;
}

QualityControl::QualityControl(const QualityGoal& goal) {
  setGoal(goal);
}

void QualityControl::setGoal(const QualityGoal& goal) {
  const double before = rungs_.empty() ? goal.ceiling : quality();
  goal_ = goal;
  goal_.floor = std::min(goal.floor, goal.ceiling);
  const double rungs = std::ceil(rungsOf(goal_.ceiling / goal_.floor) - 1e-9);
  rungs_.assign(static_cast<std::size_t>(std::clamp(rungs, 0.0, kMostRungs - 1.0)) + 1, Rung{});
  const double nearest = std::round(rungsOf(goal_.ceiling / before));
  rung_ = static_cast<int>(std::clamp(nearest, 0.0, static_cast<double>(rungs_.size() - 1)));
  samples_.clear();
}

double QualityControl::qualityOf(int rung) const {
  return std::max(goal_.ceiling * std::exp2(-rung / kRungsAnOctave), goal_.floor);
}

double QualityControl::quality() const {
  return qualityOf(rung_);
}

double QualityControl::next(const FrameCost& frame) {
  takeIn(frame);
  if (samples_.empty() || frame.time_s - looked_s_ < kBetweenLooks_s) return quality();
  looked_s_ = frame.time_s;
  if (!goDown(frame.time_s)) goUp(frame.time_s);
  return quality();
}

void QualityControl::takeIn(const FrameCost& frame) {
  const double gap_s = frame.time_s - std::exchange(last_s_, frame.time_s) - 1e-3 * frame.cost_ms;
  if (!std::exchange(hasBegun_, true) || gap_s > kLongestGap_s) settle(frame.time_s, rung_);
  if (!frame.isRepresentative || frame.time_s < settledFrom_s_) return;
  samples_.push_back({.time_s = frame.time_s, .cost_ms = frame.cost_ms, .isWhole = frame.isWhole});
  // Where frames take very long, the last few are looked at however old they are.
  const std::size_t kept = std::max(samplesSince(frame.time_s - kLongLook_s), std::min(samples_.size(), kSomeFrames));
  samples_.erase(samples_.begin(), samples_.end() - static_cast<std::ptrdiff_t>(kept));
}

/// Begins to look anew once the change of so many rungs can be seen: levels fade one after the other.
void QualityControl::settle(double now_s, int rungs) {
  samples_.clear();
  looked_s_ = now_s;
  settledFrom_s_ = now_s + (rungs > 0 ? kFade_s * (1.0 + rungs / kRungsAnOctave) : 0.0);
}

std::size_t QualityControl::samplesSince(double time_s) const {
  const auto first = std::ranges::find_if(samples_, [time_s](const Sample& s) { return s.time_s >= time_s; });
  return static_cast<std::size_t>(samples_.end() - first);
}

double QualityControl::median(std::size_t latest) {
  sorted_.clear();
  for (auto sample = samples_.end() - static_cast<std::ptrdiff_t>(latest); sample != samples_.end(); ++sample)
    sorted_.push_back(sample->cost_ms);
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(latest / 2);
  std::ranges::nth_element(sorted_, middle);
  return *middle;
}

bool QualityControl::goDown(double now_s) {
  if (rung_ + 1 == static_cast<int>(rungs_.size())) return false;
  const double looked_s = now_s - settledFrom_s_;
  const std::size_t frames = samples_.size();
  double cost_ms = 0.0;
  if ((frames >= kSomeFrames && looked_s >= kShortLook_s) || (frames >= kFewestFrames && looked_s >= kFewFrames_s)) {
    const std::size_t many = std::min(samplesSince(now_s - kNotSoShortLook_s), kManyFrames);
    const std::size_t latest = std::max({samplesSince(now_s - kShortLook_s), many, kSomeFrames});
    const double shortly_ms = median(std::min(frames, latest));
    if (shortly_ms > kFarOver * goal_.frame_ms) cost_ms = shortly_ms;
  }
  if (cost_ms == 0.0 && looked_s >= kLongEnough_s && frames >= kFewestFrames) cost_ms = median(frames);
  if (cost_ms <= goal_.frame_ms) return false;
  leave(now_s, cost_ms);
  return true;
}

/// To a lower quality, and remembers why.
void QualityControl::leave(double now_s, double cost_ms) {
  Rung& rung = rungs_[static_cast<std::size_t>(rung_)];
  const bool wasProven = now_s - settledFrom_s_ > kProven_s;
  rung.pause_s = wasProven ? kFirstPause_s : std::clamp(2.0 * rung.pause_s, kFirstPause_s, kLongestPause_s);
  rung.triedAgain_s = now_s + rung.pause_s;
  rung.tooDear_ms = cost_ms;
  rung.belowIt_ms = 0.0;
  const int down = std::min(static_cast<int>(std::ceil(rungsOf(cost_ms / goal_.frame_ms))), kMostDown);
  const int before = std::exchange(rung_, std::min(rung_ + down, static_cast<int>(rungs_.size()) - 1));
  settle(now_s, rung_ - before);
}

/// `cost_ms` is what the next lower rung costs.
bool QualityControl::mayTry(Rung& rung, double now_s, double cost_ms) {
  if (now_s >= rung.triedAgain_s) return true;
  const bool isKnown = rung.belowIt_ms > 0.0;
  if (cost_ms >= (isKnown ? kFallenOfSame * rung.belowIt_ms : kFallenOfNext * rung.tooDear_ms)) return false;
  rung = {};
  return true;
}

void QualityControl::goUp(double now_s) {
  if (rung_ == 0 || now_s - settledFrom_s_ < kShortLook_s || samples_.size() < kSomeFrames) return;
  const auto whole = static_cast<std::size_t>(std::ranges::count(samples_, true, &Sample::isWhole));
  if (2 * whole < samples_.size()) return;
  const double cost_ms = median(samples_.size());
  const bool isLong = now_s - settledFrom_s_ >= kLongEnough_s;
  if (cost_ms > (isLong ? kRoom : kFarUnder) * goal_.frame_ms) return;
  const double rungs = rungsOf(kRoom * goal_.frame_ms / std::max(cost_ms, 1e-3)) / kCostExponentUp;
  const int most = std::clamp(static_cast<int>(rungs), 1, std::min(kMostUp, rung_));
  const auto mayGoOn = [&](int up) {
    const double expected_ms = cost_ms * std::exp2(kCostExponentUp * up / kRungsAnOctave);
    return mayTry(rungs_[static_cast<std::size_t>(rung_ - up - 1)], now_s, expected_ms);
  };
  int up = 0;
  while (up < most && mayGoOn(up))
    ++up;
  if (up > 0) {
    rung_ -= up;
    settle(now_s, up);
  } else if (Rung& next = rungs_[static_cast<std::size_t>(rung_ - 1)]; isLong && next.belowIt_ms == 0.0) {
    next.belowIt_ms = cost_ms;
  }
}

}  // namespace tellurion::scene
