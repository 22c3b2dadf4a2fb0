#include "scene/tile_fetching.h"

#include <algorithm>
#include <cmath>

namespace tellurion::scene {

std::shared_ptr<TileFetch> TileFetches::fetch(LayerTiles& tiles, const tiling::TileId& id, double priority) {
  const Key key{.tiles = &tiles, .id = id};
  const auto known = fetches_.find(key);
  if (known != fetches_.end()) {
    if (auto fetch = known->second.lock()) {
      hurry(*fetch, priority);
      return fetch;
    }
  }
  auto fetch = std::make_shared<TileFetch>();
  fetch->priority_ = priority;
  fetch->pass_ = pass_;
  fetch->preparation_ = tiles.prepare(id, priority, [this, raw = fetch.get()] {
    raw->ready_.store(true, std::memory_order_release);
    bell_.ring();
  });
  if (!fetch->preparation_) return nullptr;
  fetches_[key] = fetch;
  forget();
  return fetch;
}

std::shared_ptr<TileFetch> TileFetches::found(const LayerTiles& tiles, const tiling::TileId& id) const {
  const auto known = fetches_.find({.tiles = &tiles, .id = id});
  return known != fetches_.end() ? known->second.lock() : nullptr;
}

void TileFetches::hurry(TileFetch& fetch, double priority) const {
  constexpr double kSame = 0.02;  // of itself: not worth a change
  if (fetch.pass_ == pass_) return;
  fetch.pass_ = pass_;
  if (fetch.isReady() || std::abs(priority - fetch.priority_) <= kSame * std::abs(fetch.priority_)) return;
  fetch.priority_ = priority;
  fetch.preparation_->setPriority(priority);
}

void TileFetches::forget() {
  if (fetches_.size() < forgetAt_) return;
  std::erase_if(fetches_, [](const auto& entry) { return entry.second.expired(); });
  forgetAt_ = std::max<std::size_t>(256, 2 * fetches_.size());
}

std::size_t TileFetches::count() const {
  return static_cast<std::size_t>(
      std::count_if(fetches_.begin(), fetches_.end(), [](const auto& entry) { return !entry.second.expired(); }));
}

}  // namespace tellurion::scene
