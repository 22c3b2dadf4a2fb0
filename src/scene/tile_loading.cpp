#include "scene/tile_loading.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tellurion::scene {
namespace {

/// Asked for at a time at most, the most urgent: bounds what a view of far too many tiles holds.
constexpr std::size_t kMostUnderway = 4096;
/// Tiles that network sources take part in and one update begins: telling what they need takes time.
constexpr int kMostBegun = 128;

bool has(const std::vector<TileJob::Part>& parts, const TileNeed& need) {
  return std::ranges::any_of(
      parts, [&](const TileJob::Part& part) { return part.need.tiles == need.tiles && part.need.id == need.id; });
}

/// What was at hand when it was asked for, so that nothing holds it, may be so no more: then it is to be fetched.
bool isLost(const TileNeed& need, TileJob& job) {
  const auto part = std::ranges::find_if(job.fetched, [&](const TileJob::Part& p) {
    return p.need.tiles == need.tiles && p.need.id == need.id && p.fetch == nullptr;
  });
  if (part == job.fetched.end() || !need.tiles->prepare(need.id, 0.0, [] {})) return false;
  job.fetched.erase(part);
  return true;
}

/// On a worker: holds all that making the tile will load. What cannot be loaded leads to coarser tiles; false: one of
/// those was not fetched, and loading it would wait for a network.
bool loadParts(const ContentMaker& maker, const tiling::TileId& id, TileJob& job, std::vector<TileNeed>& needs) {
  for (bool isSettled = false; !isSettled;) {
    isSettled = true;
    needs.clear();
    maker.addNeeds(id, needs);
    for (const TileNeed& need : needs) {
      if (need.isSpare || need.tiles->isMissing(need.id)) continue;
      auto tile = need.tiles->kept(need.id);
      if (!tile) {
        if (job.isStandIn && need.mayStandIn && !has(job.fetched, need)) continue;
        if (!has(job.fetched, need) || isLost(need, job)) return false;
        tile = need.tiles->get(need.id);
      }
      isSettled = isSettled && tile;
      if (tile) job.kept.push_back(std::move(tile));
    }
  }
  return true;
}

std::uint64_t refusalsOf(const std::vector<TileNeed>& needs) {
  std::uint64_t count = 0;
  for (const TileNeed& need : needs)
    count += need.tiles->refusals();
  return count;
}

/// On a worker. Null: more has to be fetched first.
std::shared_ptr<const TileContent> contentOf(const ContentMaker& maker, const tiling::TileId& id,
                                             const TileContent* parent, TileJob& job) {
  std::vector<TileNeed> needs;
  if (!loadParts(maker, id, job, needs)) return nullptr;
  // Another worker may find out meanwhile that a tile beside it fails, which changes what it is made of.
  const std::uint64_t before = refusalsOf(needs);
  auto content = job.isStandIn ? maker.makeStandIn(id) : maker.make(id, parent);
  return refusalsOf(needs) == before ? content : nullptr;
}

/// Each change takes the executor's lock, so it is not made for next to nothing.
void reorder(const WantedTile& wanted, TileJob& job) {
  constexpr double kSame = 0.02;  // of itself
  if (std::abs(wanted.priority - job.priority) <= kSame * std::abs(job.priority)) return;
  job.priority = wanted.priority;
  job.task.setPriority(wanted.priority);
}

}  // namespace

void Arrivals::add(Arrival arrival) {
  const std::lock_guard lock(mutex_);
  waiting_.push_back(std::move(arrival));
}

std::vector<Arrivals::Arrival> Arrivals::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

bool TileLoading::receive() {
  bool hasCome = false;
  for (Arrivals::Arrival& arrival : arrivals_.take()) {
    hasCome = true;
    if (arrival.content) {
      forest_.take(arrival.id, std::move(arrival.content));
      continue;
    }
    TileJob& job = *forest_.record(arrival.id).job;
    job.isShort = true;
    job.submitted = false;
    job.taken = false;
  }
  std::erase_if(underway_, [&](const tiling::TileId& id) { return !forest_.record(id).job; });
  return hasCome;
}

void TileLoading::begin(const WantedTile& wanted, TileRecord& r) {
  r.job = std::make_shared<TileJob>();
  underway_.push_back(wanted.id);
  fetchNeeds(wanted, r);
}

/// As far as they are not fetched already. A root that cannot be drawn at all waits for no picture.
void TileLoading::fetchNeeds(const WantedTile& wanted, const TileRecord& record) {
  TileJob& job = *record.job;
  job.isShort = job.isStandIn = false;
  needs_.clear();
  forest_.maker().addNeeds(wanted.id, needs_);
  for (const TileNeed& need : needs_) {
    if (auto tile = need.tiles->kept(need.id)) {
      job.kept.push_back(std::move(tile));
    } else if (!need.tiles->isMissing(need.id) && !has(job.fetched, need) && !has(job.missing, need)) {
      const bool maySkip = need.mayStandIn && !record.content;
      auto fetch = maySkip ? fetches_.found(*need.tiles, need.id) : nullptr;
      if (!fetch) fetch = fetches_.fetch(*need.tiles, need.id, wanted.priority);
      if (maySkip && fetch && !fetch->isReady()) {
        job.isStandIn = true;
        continue;
      }
      (fetch ? job.missing : job.fetched).push_back({.need = need, .fetch = std::move(fetch)});
    }
  }
}

/// False: its sources' data are still on their way.
bool TileLoading::advance(const WantedTile& wanted, TileRecord& r) {
  auto& missing = r.job->missing;
  while (!missing.empty() && missing.back().fetch->isReady()) {
    r.job->fetched.push_back(std::move(missing.back()));
    missing.pop_back();
  }
  for (const TileJob::Part& part : missing)
    fetches_.hurry(*part.fetch, wanted.priority);
  return missing.empty();
}

void TileLoading::submit(const WantedTile& wanted, TileRecord& r) {
  std::shared_ptr<const TileContent> parent;
  if (wanted.id.level > 0) parent = forest_.record(wanted.id.parent()).content;
  r.job->submitted = true;
  r.job->priority = wanted.priority;
  r.job->task = executor_.submit(
      wanted.priority, [this, id = wanted.id, parent = std::move(parent), job = r.job.get(), keep = r.job] {
        if (job->taken.exchange(true)) return;
        arrivals_.add({.id = id, .content = contentOf(forest_.maker(), id, parent.get(), *job)});
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

void TileLoading::request(std::span<const WantedTile> wanted, std::span<const WantedTile> soon) {
  fetches_.beginPass();
  begun_ = 0;
  request(wanted.first(std::min(wanted.size(), kMostUnderway)));
  request(soon);
  cancel([&](const TileRecord& r) { return r.lastWanted != forest_.updates(); });
}

void TileLoading::request(std::span<const WantedTile> wanted) {
  for (const WantedTile& w : wanted) {
    TileRecord& r = forest_.record(w.id);
    if (r.lastWanted == forest_.updates()) continue;
    r.lastWanted = forest_.updates();
    if (!r.job) {
      if (begun_ >= kMostBegun) continue;
      begin(w, r);
      if (!needs_.empty()) ++begun_;
    } else if (r.job->isShort) {
      fetchNeeds(w, r);
    }
    if (r.job->submitted) {
      reorder(w, *r.job);
    } else if (advance(w, r)) {
      submit(w, r);
    }
  }
}

void TileLoading::pause() {
  cancel([](const TileRecord& r) { return r.job->submitted; });
}

void TileLoading::stop() {
  cancel([](const TileRecord&) { return true; });
}

}  // namespace tellurion::scene
