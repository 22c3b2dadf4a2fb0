#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "scene/residency.h"
#include "scene/tile_record.h"
#include "scene/unused_records.h"

namespace tellurion::scene {

/// What is known of all tiles, loaded or not, of one set of layers. One thread only.
class TileForest final : public TileTree {
 public:
  explicit TileForest(ContentMaker maker);
  TileForest(const TileForest&) = delete;
  TileForest& operator=(const TileForest&) = delete;

  const ContentMaker& maker() const { return maker_; }
  std::uint64_t contentBytes() const { return contentBytes_; }  ///< of meshes, pictures and heights

  /// Another update: what is used from here on counts as used in it. looks: of the imagery layers; gpu: what is on it,
  /// or null; it is asked while the update lasts.
  void begin(double exaggeration, std::span<const LayerLook> looks, const Residency* gpu);
  std::uint64_t updates() const { return updates_; }
  /// What the last update found is what one with these would find, but for what has come since.
  bool isAsAt(double exaggeration, std::span<const LayerLook> looks, const Residency* gpu) const;
  std::uint64_t renewals() const { return renewals_; }  ///< how often renew() was called

  TileFacts* root(int root) override;
  std::array<TileFacts*, 4> children(const tiling::TileId& id, TileFacts& facts) override;

  /// Made when it is not there yet.
  TileRecord& record(const tiling::TileId& id);
  /// Null: nobody asked for it yet.
  const TileRecord* find(const tiling::TileId& id) const;
  /// What was made of a tile, also in place of what stood in for it.
  void take(const tiling::TileId& id, std::shared_ptr<const TileContent> content);
  /// Another content of a tile that has one, the same but for pictures.
  void renew(const tiling::TileId& id, std::shared_ptr<const TileContent> content);

  /// How deep below the ellipsoid the ground lies at most, as far as the roots tell.
  double occluderDepth_m() const;
  /// Drops what has not been used for longest until contents take no more than that; never what this update used, nor
  /// what was used since the update of number `heldSince`: by so much it may be more. What it costs goes with what is
  /// dropped, not with what there is.
  void evict(std::uint64_t budgetBytes, std::uint64_t heldSince = std::numeric_limits<std::uint64_t>::max());

 private:
  TileFacts* use(TileRecord& r);
  void countAsUsed(TileRecord& r);
  void sortOutUnused();
  void drop(TileRecord& r);
  void lookAt(std::span<const LayerLook> looks);
  void takeCopies(TileRecord& r) const;
  void takeTexels(TileRecord& r) const;
  void takeParts(TileRecord& r) const;
  double reachOfParent_m(const tiling::TileId& id) const;
  OrientedBox drawnBox(const tiling::TileId& id, const HeightRange& range) const;
  void makeBox(TileRecord& r) const;
  void takeFacts(TileRecord& r) const;

  ContentMaker maker_;
  std::unordered_map<tiling::TileId, TileRecord, tiling::TileIdHash> records_;
  std::vector<TileRecord*> used_;      ///< by this update, until it sorts out what is unused
  std::vector<TileRecord*> lastUsed_;  ///< by the one before, and after that by this one
  bool isSortedOut_ = true;            ///< this update has
  UnusedRecords unused_;               ///< all others
  std::uint64_t contentBytes_ = 0;
  std::uint64_t updates_ = 0;
  std::uint64_t renewals_ = 0;
  double exaggeration_ = 1.0;
  const Residency* gpu_ = nullptr;  ///< of this update
  std::uint64_t departures_ = 0;    ///< of that
  std::uint64_t arrivals_ = 0;      ///< of that
  std::uint64_t residency_ = 0;     ///< rises when something may have left, and with another GPU
  std::vector<bool> isVisible_;     ///< of each imagery layer, in this update
  std::uint64_t visibility_ = 1;    ///< rises when that changes
};

}  // namespace tellurion::scene
