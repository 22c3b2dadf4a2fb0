#include "scene/layer_series.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr std::chrono::seconds kLongestRetry{30};

}  // namespace

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

void LayerSeries::open(std::size_t index, Step& step, Clock::time_point now, SourceOpeners& openers,
                       LoadLedger& ledger) {
  if (auto source = step.opening ? step.opening->take() : std::nullopt) {
    step.opening.reset();
    take(step, std::move(*source), now, ledger);
  }
  if (step.tiles || step.failed || step.opening || now < step.retryAt) return;
  const LayerSource& source = sources_[index].source;
  if (source.open) {
    take(step, source.open, now, ledger);
  } else if (openers.mayOpen(source)) {
    step.opening = openers.open(source);
  }
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

void LayerSeries::advance(Clock::time_point now, SourceOpeners& openers, LoadLedger& ledger) {
  if (!current_->now().tiles) return;  // it has not joined
  if (wanted_ != shown_) {
    Step& step = steps_[wanted_];
    open(wanted_, step, now, openers, ledger);
    if (step.tiles) {
      current_->set(step.tiles);
      shown_ = wanted_;
      setClock(sources_[wanted_].time_s, forwards_);
    }
  }
  if (const auto next = after(); next && wanted_ == shown_) open(*next, steps_[*next], now, openers, ledger);
}

bool LayerSeries::isDue(Clock::time_point now, const SourceOpeners& openers) const {
  const auto index = wanted_ != shown_ ? std::optional(wanted_) : after();
  const auto found = index ? steps_.find(*index) : steps_.end();
  if (found == steps_.end()) return false;
  const Step& step = found->second;
  const bool isOpened = step.tiles || step.failed || step.opening;
  const LayerSource& source = sources_[found->first].source;
  return !isOpened && now >= step.retryAt && (source.open || openers.mayOpen(source));
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
