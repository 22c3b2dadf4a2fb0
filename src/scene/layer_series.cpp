#include "scene/layer_series.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr std::chrono::seconds kLongestRetry{30};

}  // namespace

/// What the thread that opens a step fills in.
struct LayerSeries::Opened {
  std::atomic<bool> done{false};
  io::Result<LayerSource::Pointer> source;
};

std::size_t stepAt(const std::vector<TimedSource>& steps, double time_s) {
  const auto later = std::upper_bound(steps.begin(), steps.end(), time_s,
                                      [](double time, const TimedSource& step) { return time < step.time_s; });
  return later == steps.begin() ? 0 : static_cast<std::size_t>(later - steps.begin()) - 1;
}

LayerSeries::LayerSeries(std::vector<TimedSource> steps, std::size_t shown, MakeTiles makeTiles, Doorbell& bell)
    : sources_(std::move(steps)), makeTiles_(std::move(makeTiles)), bell_(bell), shown_(shown), wanted_(shown) {}

void LayerSeries::setClock(double time_s, bool forwards) {
  wanted_ = stepAt(sources_, time_s);
  forwards_ = forwards;
  const auto next = after();
  std::erase_if(steps_, [&](const auto& step) { return step.first != wanted_ && step.first != next; });
}

std::optional<std::size_t> LayerSeries::after() const {
  if (forwards_) return wanted_ + 1 < sources_.size() ? std::optional(wanted_ + 1) : std::nullopt;
  return wanted_ > 0 ? std::optional(wanted_ - 1) : std::nullopt;
}

void LayerSeries::open(std::size_t index, Step& step, Clock::time_point now, io::Executor& opener, LoadLedger& ledger) {
  if (step.opened && step.opened->done.load(std::memory_order_acquire)) {
    const auto slot = std::exchange(step.opened, nullptr);
    take(step, std::move(slot->source), now, ledger);
  }
  if (step.tiles || step.failed || step.opened || now < step.retryAt) return;
  const LayerSource& source = sources_[index].source;
  if (source.open) {
    take(step, source.open, now, ledger);
    return;
  }
  step.opened = std::make_shared<Opened>();
  opener.submit(0.0, [slot = step.opened, how = source.opening, &bell = bell_] {
    slot->source = how();
    slot->done.store(true, std::memory_order_release);
    bell.ring();
  });
}

void LayerSeries::take(Step& step, io::Result<LayerSource::Pointer> source, Clock::time_point now, LoadLedger& ledger) {
  if (!source && source.error().code == io::Failure::Code::ioError) {
    step.retryAt = now + step.retryIn;
    step.retryIn = std::min(2 * step.retryIn, kLongestRetry);
    return;
  }
  auto tiles = source ? makeTiles_(std::move(*source)) : tl::unexpected(std::move(source.error()));
  if (tiles) {
    step.tiles = std::move(*tiles);
  } else {
    step.failed = true;
    ledger.add({.failure = std::move(tiles.error())});
  }
}

void LayerSeries::advance(Clock::time_point now, io::Executor& opener, LoadLedger& ledger) {
  if (!current_->now().tiles) return;  // it has not joined
  if (wanted_ != shown_) {
    Step& step = steps_[wanted_];
    open(wanted_, step, now, opener, ledger);
    if (step.tiles) {
      current_->set(step.tiles);
      shown_ = wanted_;
      setClock(sources_[wanted_].time_s, forwards_);
    }
  }
  if (const auto next = after(); next && wanted_ == shown_) open(*next, steps_[*next], now, opener, ledger);
}

bool LayerSeries::isDue(Clock::time_point now) const {
  const auto index = wanted_ != shown_ ? std::optional(wanted_) : after();
  const auto found = index ? steps_.find(*index) : steps_.end();
  if (found == steps_.end()) return false;
  const Step& step = found->second;
  return !step.tiles && !step.failed && !step.opened && now >= step.retryAt;
}

std::shared_ptr<LayerTiles> LayerSeries::upcoming() const {
  const auto next = after();
  const auto found = next ? steps_.find(*next) : steps_.end();
  return found != steps_.end() ? found->second.tiles : nullptr;
}

bool LayerSeries::isComing() const {
  const auto found = steps_.find(wanted_);
  return wanted_ != shown_ && (found == steps_.end() || !found->second.failed);
}

std::uint64_t LayerSeries::bytes() const {
  std::uint64_t bytes = 0;
  const auto shown = current_->now().tiles;
  for (const auto& [index, step] : steps_) {
    if (step.tiles && step.tiles != shown) bytes += step.tiles->bytes();
  }
  return bytes + (shown ? shown->bytes() : 0);
}

}  // namespace tellurion::scene
