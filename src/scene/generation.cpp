#include "scene/generation.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {

namespace {

/// How far a morph value may go in that time: 1 is all of its way.
double waysBetween(double from_s, double to_s, const CutOptions& options) {
  return std::max((to_s - from_s) / options.fade_s, 0.0);
}

}  // namespace

void Generation::receive() {
  const std::uint64_t before = forest.contentBytes();
  if (loading.receive()) hasArrivals_ = true;  // also what comes after the bell was looked at
  if (forest.contentBytes() != before) lastArrival_ = std::chrono::steady_clock::now();
}

const Selection& Generation::cut(const View& view, const CutOptions& asked, double exaggeration,
                                 std::span<const LayerLook> looks, const Residency* gpu, bool mayKeep, bool hasCome) {
  CutOptions options = asked;
  options.isNested = asked.isNested && groundIsNested_;
  // Who stays at one time waits for what has come.
  const bool isUrgent = hasCome && now_ && options.time_s == now_->time_s;
  hasArrivals_ = hasArrivals_ || hasCome;
  tellTime(view, options);
  if (mayKeep && !isUrgent && canKeep(view, options, exaggeration, looks, gpu)) {
    receive();
    ++age_;
    if (lastCut_->fading <= 0.0f) return *lastCut_;
    return selector_.goOn(waysBetween(*memoryTimes_s_[1], now_->time_s, options), memories_[1]);
  }
  age_ = 0;
  forest.begin(exaggeration, looks, gpu);
  receive();
  hasArrivals_ = false;
  madeRenewals_ = forest.renewals();
  const CutHistory* history = historyFor(view, options);
  const Selection& selection = selector_.select(view, options, forest.occluderDepth_m(), forest, history);
  made_.reset();
  if (history != nullptr) made_ = {.view = view, .options = options, .leeway = history->leeway};
  rootShares_ = selection.rootShares;
  lastCut_ = &selection;
  return selection;
}

/// What has to go on soon, since something is on its way, is made again after a few updates at the latest.
bool Generation::canKeep(const View& view, const CutOptions& options, double exaggeration,
                         std::span<const LayerLook> looks, const Residency* gpu) const {
  constexpr int kMostUnsettled = 3;
  if (!now_ || !made_ || lastCut_->heldBack > 0 || isRenewed()) return false;
  // What rests is drawn as if nothing had ever moved.
  const bool rests = before_ && isWithin(view, before_->view, {});
  if (rests && hasLeeway()) return false;
  CutOptions madeNow = made_->options;
  madeNow.time_s = options.time_s;
  if (madeNow != options || *options.time_s < *memoryTimes_s_[1]) return false;
  return (isSettled() || age_ < kMostUnsettled) && forest.isAsAt(exaggeration, looks, gpu) &&
         isWithin(view, made_->view, made_->leeway);
}

bool Generation::rootsAreDrawable() const {
  for (int root = 0; root < forest.maker().tiling.rootCount(); ++root) {
    const TileRecord* record = forest.find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    if (record == nullptr || !record->drawable) return false;
  }
  return true;
}

bool Generation::lacksRoots() const {
  for (std::size_t root = 0; root < rootShares_.size(); ++root) {
    const TileRecord* record = forest.find({.level = 0, .root = static_cast<std::uint8_t>(root)});
    if (rootShares_[root] > 0.0 && (record == nullptr || !record->drawable || record->isStandIn)) return true;
  }
  return false;
}

std::vector<const LayerTiles*> Generation::waitedFor() const {
  std::vector<const LayerTiles*> out;
  for (std::size_t i = 0; lastCut_ != nullptr && i < lastCut_->wanted.size(); ++i) {
    const TileRecord* record = forest.find(lastCut_->wanted[i].id);
    if (record == nullptr || !record->job) continue;
    for (const TileJob::Part& part : record->job->missing) {
      if (!part.fetch->isReady() && std::ranges::find(out, part.need.tiles) == out.end())
        out.push_back(part.need.tiles);
    }
  }
  return out;
}

void Generation::tellTime(const View& view, const CutOptions& options) {
  if (!options.time_s || !options.morph) {
    now_ = before_ = std::nullopt;
    return;
  }
  if (now_ && now_->time_s != *options.time_s) before_ = now_;
  now_ = {.view = view, .time_s = *options.time_s};
}

/// Updates at one time all start from what was drawn at the time before, so that the last of them, when all has come,
/// does not depend on the order of arrivals.
const CutHistory* Generation::historyFor(const View& view, const CutOptions& options) {
  if (!now_) {
    memoryTimes_s_ = {};
    for (CutMemory& memory : memories_) {
      memory.clear();
      memory.corners.clear();
    }
    return nullptr;
  }
  if (memoryTimes_s_[1] != now_->time_s) {
    std::swap(memories_[0], memories_[1]);
    memoryTimes_s_[0] = std::exchange(memoryTimes_s_[1], now_->time_s);
  }
  if (before_ && memoryTimes_s_[0])
    memories_[0].corners.goOn(static_cast<float>(waysBetween(*memoryTimes_s_[0], before_->time_s, options)));
  history_.step = before_ ? std::min(waysBetween(before_->time_s, now_->time_s, options), 1.0) : 1.0;
  history_.leeway = {};
  if (before_ && made_) {
    const double nearest_m = lastCut_->nearest_m + made_->leeway.move_m - geo::length(view.eye - made_->view.eye);
    history_.leeway = leewayFor(before_->view, view, std::min(nearest_m, forest.maker().ellipsoid.semiMinorAxis_m()));
  }
  return &history_;
}

}  // namespace tellurion::scene
