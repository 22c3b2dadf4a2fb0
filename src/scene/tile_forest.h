#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "scene/residency.h"
#include "scene/select.h"
#include "scene/tile_content.h"

namespace tellurion::scene {

struct TileJob;

struct TileRecord final : TileFacts {
  double madeFor = 1.0;                   ///< the exaggeration that the facts were made for
  std::array<TileRecord*, 4> children{};  ///< their records, once they were asked for
  std::shared_ptr<const TileContent> content;
  std::shared_ptr<TileJob> job;  ///< asked for and not here yet
  std::uint64_t residency = 0;   ///< number of what was on the GPU when facts.copy_bytes was asked for
  std::uint64_t arrivals = 0;    ///< on the GPU, so far, at that time
  std::uint64_t visibility = 0;  ///< number of the layers in sight that facts.texel_m was made for
  std::uint64_t lastUse = 0;     ///< number of the update that used it last
  std::uint64_t lastWanted = 0;  ///< number of the update that asked for it last
};

/// What is known of all tiles, loaded or not, of one set of layers. One thread only.
class TileForest final : public TileTree {
 public:
  explicit TileForest(ContentMaker maker) : maker_(std::move(maker)) {}
  TileForest(const TileForest&) = delete;
  TileForest& operator=(const TileForest&) = delete;

  const ContentMaker& maker() const { return maker_; }
  std::uint64_t contentBytes() const { return contentBytes_; }  ///< of meshes, pictures and heights

  /// Another update: what is used from here on counts as used in it. looks: of the imagery layers; gpu: what is on it,
  /// or null; both are asked while the update lasts.
  void begin(double exaggeration, std::span<const LayerLook> looks, const Residency* gpu);
  std::uint64_t updates() const { return updates_; }

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
  /// Drops what has not been used for longest until contents take no more than that; never what this update used.
  void evict(std::uint64_t budgetBytes);

 private:
  TileFacts* use(const tiling::TileId& id, TileRecord& r);
  void lookAt(std::span<const LayerLook> looks);
  void takeCopies(int level, TileRecord& r) const;
  void takeTexels(TileRecord& r) const;
  void takeParts(TileRecord& r) const;
  double reachOfParent_m(const tiling::TileId& id) const;
  OrientedBox drawnBox(const tiling::TileId& id, const HeightRange& range) const;
  void makeBox(const tiling::TileId& id, TileRecord& r) const;
  void takeFacts(const tiling::TileId& id, TileRecord& r) const;

  ContentMaker maker_;
  std::unordered_map<tiling::TileId, TileRecord, tiling::TileIdHash> records_;
  std::uint64_t contentBytes_ = 0;
  std::uint64_t updates_ = 0;
  double exaggeration_ = 1.0;
  const Residency* gpu_ = nullptr;    ///< of this update
  std::uint64_t departures_ = 0;      ///< of that
  std::uint64_t arrivals_ = 0;        ///< of that
  std::uint64_t residency_ = 0;       ///< rises when something may have left, and with another GPU
  std::span<const LayerLook> looks_;  ///< of this update
  std::vector<bool> wasVisible_;      ///< of each imagery layer
  std::uint64_t visibility_ = 1;      ///< rises when that changes
};

}  // namespace tellurion::scene
