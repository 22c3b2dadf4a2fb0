#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <unordered_map>

#include "scene/doorbell.h"
#include "scene/layer_tiles.h"

namespace tellurion::scene {

/// What a source's tile needs, on its way or here; as long as it lives the tile can be loaded without waiting once it
/// is ready. Shared by all who need the tile; cancelled when the last of them lets go. May be let go of on any thread.
class TileFetch {
 public:
  bool isReady() const { return ready_.load(std::memory_order_acquire); }

 private:
  friend class TileFetches;
  std::atomic<bool> ready_{false};
  double priority_ = 0.0;
  std::uint64_t pass_ = 0;
  std::unique_ptr<raster::Preparation> preparation_;  ///< last: once it is gone, nobody sets ready_
};

/// All tiles of network sources that are being fetched for a globe: none is prepared twice at a time. One thread only.
class TileFetches {
 public:
  /// The bell is rung, on a thread of the source, when something is ready; it must outlive all fetches.
  explicit TileFetches(Doorbell& bell) : bell_(bell) {}
  TileFetches(const TileFetches&) = delete;
  TileFetches& operator=(const TileFetches&) = delete;

  /// A new round of asking. In each the first who names a fetch decides its priority, so the most urgent asks first.
  void beginPass() { ++pass_; }
  /// Begun, or joined where it is on its way. Null: there is nothing to wait for.
  std::shared_ptr<TileFetch> fetch(LayerTiles& tiles, const tiling::TileId& id, double priority);
  /// Begun before, by somebody who still wants it; else null.
  std::shared_ptr<TileFetch> found(const LayerTiles& tiles, const tiling::TileId& id) const;
  void hurry(TileFetch& fetch, double priority) const;
  /// That are on their way or held.
  std::size_t count() const;

 private:
  struct Key {
    const LayerTiles* tiles = nullptr;
    tiling::TileId id;
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const {
      return tiling::TileIdHash{}(key.id) ^ (std::hash<const LayerTiles*>{}(key.tiles) * 0x9e3779b97f4a7c15u);
    }
  };
  void forget();

  Doorbell& bell_;
  std::uint64_t pass_ = 0;
  std::unordered_map<Key, std::weak_ptr<TileFetch>, KeyHash> fetches_;
  std::size_t forgetAt_ = 256;  ///< entries at which those that are over are dropped
};

}  // namespace tellurion::scene
