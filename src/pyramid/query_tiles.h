#pragma once

#include <array>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "raster/shared_cache.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// A decoded tile, as places on it are asked for.
struct QueryTile {
  tiling::TileId id;
  std::uint8_t childMask = 0;
  double error_m = 0.0;
  raster::Raster<float> heights;  ///< elevation: (cells + 1)^2, the gutter is gone
  raster::Raster<float> joined;   ///< the same as the surface has it (joinedHeights); empty: nothing is different
  double joinShift_m = 0.0;       ///< by how much at most a height of `joined` is another than in `heights`
  raster::Raster<raster::Rgba8> pixels;  ///< imagery: with the gutter

  /// Whether a place of the root is on this tile and a question no deeper than `level` ends at it.
  bool answers(const tiling::RootPoint& p, int level) const;
  /// Whether a deeper tile is stored under a place that is on this one.
  bool hasFiner(const tiling::RootPoint& p) const;
  /// Begins to bring the heights around a place into the processor's cache, if it is on this tile.
  void fetchAround(const tiling::RootPoint& p) const;
};

/// A place of a tile's square, in [0, 1], t down.
struct TilePlace {
  double s = 0.0;
  double t = 0.0;
};
inline TilePlace placeIn(const tiling::TileId& id, const tiling::RootPoint& p) {
  const auto tiles = static_cast<double>(std::int64_t{1} << id.level);
  return {p.u * tiles - id.x, p.v * tiles - id.y};
}

inline void QueryTile::fetchAround(const tiling::RootPoint& p) const {
  const TilePlace place = placeIn(id, p);
  const bool isHere = p.root == id.root && place.s >= 0.0 && place.s < 1.0 && place.t >= 0.0 && place.t < 1.0;
  if (!isHere || heights.samples.empty()) return;
  const int cells = heights.width - 1;
  const float* top = &heights.at(static_cast<int>(place.s * cells), static_cast<int>(place.t * cells));
  __builtin_prefetch(top);
  __builtin_prefetch(top + heights.width);
}

/// The tiles of a source that places are asked of, decoded ones kept up to a budget. Thread-safe.
class QueryTiles {
 public:
  using Pointer = std::shared_ptr<const QueryTile>;

  QueryTiles(std::shared_ptr<const raster::TileSource> source, std::uint64_t cacheBytes);

  const raster::TileSource& source() const { return *source_; }
  const tiling::Tiling& tiling() const { return tiling_; }
  /// Mean metres between the samples of a level.
  double spacing_m(int level) const { return spacing_m_[static_cast<std::size_t>(level)]; }

  /// The deepest stored tile over a place, no deeper than `level`; null where there is none. Fails on what load() fails
  /// on, and where a tile that its parent tells of is missing.
  io::Result<Pointer> finest(const tiling::RootPoint& p, int level);

  /// Calls visit(i, root point, tile or null) for each place: those on one tile one after the other, so that each tile
  /// is looked for once; not in the order of the places. Places with NaN get null. Stops at the first failure.
  /// announce(i) comes a little before it, to fetch what visit(i) will write to.
  template <class Visit, class Announce>
  io::Result<void> visit(std::span<const geo::Direction> places, int level, const Visit& visit,
                         const Announce& announce);

  /// What answer(root point, tile or null) says of one place, and of each of many: `answers` is as long as `places`.
  template <class Answer, class Answering>
  io::Result<std::optional<Answer>> ask(const geo::Direction& place, int level, const Answering& answer) {
    const tiling::RootPoint point = tiling_.rootPoint(place);
    const auto tile = finest(point, level);
    if (!tile) return tl::unexpected(tile.error());
    return answer(point, tile->get());
  }
  template <class Answer, class Answering>
  io::Result<void> ask(std::span<const geo::Direction> places, std::span<std::optional<Answer>> answers, int level,
                       const Answering& answer) {
    assert(places.size() == answers.size());
    return visit(
        places, level,
        [&](std::size_t i, const tiling::RootPoint& p, const QueryTile* tile) { answers[i] = answer(p, tile); },
        [&](std::size_t i) { __builtin_prefetch(&answers[i], 1); });
  }

 private:
  using TileCache = raster::SharedCache<tiling::TileId, QueryTile, tiling::TileIdHash>;
  using PresenceCache = raster::SharedCache<tiling::TileId, raster::TilePresence, tiling::TileIdHash>;
  static constexpr std::size_t kShards = 16;  ///< threads that ask at once seldom meet at one
  struct Shard {
    Shard(std::uint64_t tileBytes, std::uint64_t presenceBytes) : tiles(tileBytes), presences(presenceBytes) {}
    TileCache tiles;
    PresenceCache presences;
  };

  Shard& shardOf(const tiling::TileId& id);
  io::Result<Pointer> tile(const tiling::TileId& id);
  io::Result<Pointer> loaded(const tiling::TileId& id);
  io::Result<raster::TilePresence> presenceOf(const tiling::TileId& id);
  io::Result<bool> isStored(const tiling::TileId& id);
  io::Result<void> join(QueryTile& tile);
  std::atomic<std::uint8_t>& hintAt(const tiling::RootPoint& p);

  std::shared_ptr<const raster::TileSource> source_;
  tiling::Tiling tiling_;
  std::array<double, tiling::kMaxLevel + 1> spacing_m_{};
  std::vector<std::unique_ptr<Shard>> shards_;
  std::vector<std::atomic<std::uint8_t>> hints_;  ///< the level that answered last, for each tile of kHintLevel
};

/// Places in an order in which those on one tile, of whatever level, follow each other: along the Morton curve.
struct OrderedPlaces {
  std::vector<tiling::RootPoint> points;  ///< of each place, in the places' own order
  std::vector<std::uint32_t> order;       ///< their numbers
};
OrderedPlaces alongTheCurve(const tiling::Tiling& tiling, std::span<const geo::Direction> places);

template <class Visit, class Announce>
io::Result<void> QueryTiles::visit(std::span<const geo::Direction> places, int level, const Visit& visit,
                                   const Announce& announce) {
  const OrderedPlaces ordered = alongTheCurve(tiling_, places);
  const std::vector<std::uint32_t>& order = ordered.order;
  constexpr std::size_t kAhead =
      16;                           // places and answers lie anywhere in memory: they are fetched while others are made
  constexpr std::size_t kSoon = 6;  // and so are samples, once the place is here
  Pointer tile;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k + kAhead < order.size()) {
      __builtin_prefetch(&ordered.points[order[k + kAhead]]);
      announce(order[k + kAhead]);
    }
    if (tile != nullptr && k + kSoon < order.size()) tile->fetchAround(ordered.points[order[k + kSoon]]);
    const std::uint32_t i = order[k];
    const tiling::RootPoint& p = ordered.points[i];
    if (tile == nullptr || !tile->answers(p, level)) {
      auto found = finest(p, level);
      if (!found) return tl::unexpected(found.error());
      tile = std::move(*found);
    }
    visit(i, p, tile.get());
  }
  return {};
}

}  // namespace tellurion::pyramid
