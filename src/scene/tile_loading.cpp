#include "scene/tile_loading.h"

#include <algorithm>
#include <utility>

namespace tellurion::scene {
namespace {

/// Asked for at a time at most, the most urgent: bounds what a view of far too many tiles holds.
constexpr std::size_t kMostUnderway = 4096;
/// Tiles that network sources take part in and one update begins: telling what they need takes time.
constexpr int kMostBegun = 128;

}  // namespace

void Arrivals::add(Arrival arrival) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(arrival));
}

std::vector<Arrivals::Arrival> Arrivals::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

void TileLoading::receive() {
  for (Arrivals::Arrival& arrival : arrivals_.take())
    forest_.take(arrival.id, std::move(arrival.content));
  std::erase_if(underway_, [&](const tiling::TileId& id) { return !forest_.record(id).job; });
}

void TileLoading::begin(const WantedTile& wanted, TileRecord& r) {
  r.job = std::make_shared<TileJob>();
  underway_.push_back(wanted.id);
  needs_.clear();
  forest_.maker().addNeeds(wanted.id, needs_);
  for (const TileNeed& need : needs_) {
    if (auto tile = need.tiles->kept(need.id)) {
      r.job->kept.push_back(std::move(tile));
    } else if (!need.tiles->isMissing(need.id)) {
      auto fetch = fetches_.fetch(*need.tiles, need.id, wanted.priority);
      if (fetch) r.job->missing.push_back(std::move(fetch));
    }
  }
}

/// False: its sources' data are still on their way.
bool TileLoading::advance(const WantedTile& wanted, TileRecord& r) {
  auto& missing = r.job->missing;
  while (!missing.empty() && missing.back()->isReady()) {
    r.job->fetched.push_back(std::move(missing.back()));
    missing.pop_back();
  }
  for (const auto& fetch : missing)
    fetches_.hurry(*fetch, wanted.priority);
  return missing.empty();
}

void TileLoading::submit(const WantedTile& wanted, TileRecord& r) {
  std::shared_ptr<const TileContent> parent;
  if (wanted.id.level > 0) parent = forest_.record(wanted.id.parent()).content;
  r.job->submitted = true;
  r.job->task = executor_.submit(wanted.priority,
                                 [this, id = wanted.id, parent = std::move(parent), job = r.job.get(), keep = r.job] {
                                   if (job->taken.exchange(true)) return;
                                   arrivals_.add({.id = id, .content = forest_.maker().make(id, parent.get())});
                                   bell_.ring();
                                 });
}

/// What has begun goes on to its end.
template <class IsUnwanted>
void TileLoading::cancel(const IsUnwanted& isUnwanted) {
  std::erase_if(underway_, [&](const tiling::TileId& id) {
    TileRecord& r = forest_.record(id);
    if (!isUnwanted(r) || r.job->taken.exchange(true)) return false;
    r.job->task.cancel();
    r.job.reset();
    return true;
  });
}

void TileLoading::request(const std::vector<WantedTile>& wanted) {
  fetches_.beginPass();
  int begun = 0;
  for (std::size_t i = 0; i < std::min(wanted.size(), kMostUnderway); ++i) {
    const WantedTile& w = wanted[i];
    TileRecord& r = forest_.record(w.id);
    r.lastWanted = forest_.updates();
    if (!r.job) {
      if (begun >= kMostBegun) continue;
      begin(w, r);
      if (!needs_.empty()) ++begun;
    }
    if (r.job->submitted) {
      r.job->task.setPriority(w.priority);
    } else if (advance(w, r)) {
      submit(w, r);
    }
  }
  cancel([&](const TileRecord& r) { return r.lastWanted != forest_.updates(); });
}

void TileLoading::pause() {
  cancel([](const TileRecord& r) { return r.job->submitted; });
}

void TileLoading::stop() {
  cancel([](const TileRecord&) { return true; });
}

}  // namespace tellurion::scene
