#include "scene/tile_loading.h"

#include <utility>

namespace tellurion::scene {

void Arrivals::add(Arrival arrival) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(arrival));
  }
  arrived_.notify_all();
}

std::vector<Arrivals::Arrival> Arrivals::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(waiting_, {});
}

bool Arrivals::wait(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  return arrived_.wait_for(lock, timeout, [&] { return !waiting_.empty(); });
}

void TileLoading::receive() {
  for (Arrivals::Arrival& arrival : arrivals_.take())
    forest_.take(arrival.id, std::move(arrival.content));
  std::erase_if(underway_, [&](const tiling::TileId& id) { return !forest_.record(id).job; });
}

void TileLoading::submit(const WantedTile& wanted, TileRecord& r) {
  std::shared_ptr<const TileContent> parent;
  if (wanted.id.level > 0) parent = forest_.record(wanted.id.parent()).content;
  r.job = std::make_shared<TileJob>();
  r.job->task = executor_.submit(wanted.priority,
                                 [this, id = wanted.id, parent = std::move(parent), job = r.job.get(), keep = r.job] {
                                   if (job->taken.exchange(true)) return;
                                   arrivals_.add({.id = id, .content = forest_.maker().make(id, parent.get())});
                                 });
  underway_.push_back(wanted.id);
}

void TileLoading::request(const std::vector<WantedTile>& wanted) {
  for (const WantedTile& w : wanted) {
    TileRecord& r = forest_.record(w.id);
    r.lastWanted = forest_.updates();
    if (r.job) {
      r.job->task.setPriority(w.priority);
    } else {
      submit(w, r);
    }
  }
  cancelUnwanted();
}

void TileLoading::cancelUnwanted() {
  std::erase_if(underway_, [&](const tiling::TileId& id) {
    TileRecord& r = forest_.record(id);
    if (r.lastWanted == forest_.updates() || r.job->taken.exchange(true)) return false;
    r.job->task.cancel();
    r.job.reset();
    return true;
  });
}

}  // namespace tellurion::scene
