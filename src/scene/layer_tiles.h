#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "raster/tile_source.h"

namespace tellurion::scene {

/// What could not be had, and which tile of a source it was; none: a whole layer.
struct LoadFailure {
  io::Failure failure;
  std::optional<tiling::TileId> tile;
};

/// Counts of what was asked of all layers' sources, and what went wrong. Thread-safe.
class LoadLedger {
 public:
  void countRequest() { ++requests_; }
  void add(LoadFailure failure);
  std::uint64_t requests() const { return requests_; }
  /// Failures since the last call.
  std::vector<LoadFailure> takeFailures();

 private:
  std::atomic<std::uint64_t> requests_{0};
  std::mutex mutex_;
  std::vector<LoadFailure> failures_;
};

/// The decoded tiles of one source, in a cache with a byte budget. Never asks the source for a tile that is loaded,
/// being loaded, known not to exist, or failed before. A tile that someone holds is not dropped, since that would free
/// nothing. Thread-safe; get() blocks while the source does.
class LayerTiles {
 public:
  using TilePointer = std::shared_ptr<const raster::SourceTile>;

  LayerTiles(std::shared_ptr<const raster::TileSource> source, std::uint64_t budgetBytes,
             std::shared_ptr<LoadLedger> ledger);

  const raster::TileSourceInfo& info() const { return source_->info(); }
  /// Null: there is no such tile, or it could not be loaded, or is missing though its parent lists it (which the ledger
  /// is told once, but of sources that tell what they store before they have looked).
  TilePointer get(const tiling::TileId& id);
  /// The deepest level, at most that of `id`, at which the tile over it is stored; -1: none. What parents tell of their
  /// children decides, so tiles above `id` may be loaded, `id` itself only when it is a root.
  int storedLevel(const tiling::TileId& id);
  /// Whether the source tells what is stored without being asked to load: then storedLevel() waits for nothing. Only
  /// such a source may have something to prepare.
  bool tellsPresence() const { return tellsPresence_; }
  /// The decoded tile, if it is here. Never blocks.
  TilePointer kept(const tiling::TileId& id);
  /// For those who make contents: as get(), but of a source that tells what it stores only what is kept, since another
  /// load may wait for a network. Null though the tile may exist counts as a refusal.
  TilePointer held(const tiling::TileId& id);
  std::uint64_t refusals() const { return refusals_; }
  /// Known not to exist, or to have failed. Never blocks.
  bool isMissing(const tiling::TileId& id) const;
  /// As the source does.
  std::unique_ptr<raster::Preparation> prepare(const tiling::TileId& id, double priority,
                                               std::function<void()> ready) const {
    return source_->prepare(id, priority, std::move(ready));
  }
  /// As the source's; what it is of may be shown to others.
  std::optional<io::Failure> complaint() const;
  /// Of decoded tiles and of what is known of others.
  std::uint64_t bytes() const;
  /// Another tile may drive out one that is kept.
  bool isFull() const;

 private:
  struct Entry {
    bool loading = true;
    TilePointer tile;
    std::uint64_t bytes = 0;
    std::list<tiling::TileId>::iterator use;
  };
  /// The children of a tile that is stored, known beyond the tile itself while there is room (kKnownShare); missing and
  /// failed tiles are known as such for ever.
  struct Known {
    bool stored = false;
    std::uint8_t childMask = 0;
  };
  Known know(const tiling::TileId& id);
  TilePointer load(const tiling::TileId& id);
  /// As far as is known: a parent that is neither kept nor known any more lists nothing.
  bool parentLists(const tiling::TileId& id) const;
  void trim();
  void forget();

  std::shared_ptr<const raster::TileSource> source_;
  std::uint64_t budgetBytes_;
  std::shared_ptr<LoadLedger> ledger_;
  bool tellsPresence_;
  std::atomic<std::uint64_t> refusals_{0};
  mutable std::mutex mutex_;
  std::condition_variable loaded_;
  std::unordered_map<tiling::TileId, Entry, tiling::TileIdHash> tiles_;
  std::unordered_map<tiling::TileId, Known, tiling::TileIdHash> known_;
  std::list<tiling::TileId> uses_;  ///< most recent first
  std::uint64_t bytes_ = 0;
};

/// A tile that will be asked for.
struct TileNeed {
  LayerTiles* tiles = nullptr;
  tiling::TileId id;
  bool mayStandIn = false;  ///< a root's picture: there is something to show without it
  bool isSpare = false;     ///< asked for only when it turns out that there is no such tile one level below it
};

/// The tile over `id` at a level, and the one that is asked for instead when it turns out that there is none.
inline void addNeed(LayerTiles& tiles, const tiling::TileId& id, int level, std::vector<TileNeed>& needs) {
  for (int each = level; each >= std::max(level - 1, 0); --each)
    needs.push_back({.tiles = &tiles, .id = id.ancestor(each), .isSpare = each < level});
}

}  // namespace tellurion::scene
