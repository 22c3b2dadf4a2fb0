#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "scene/select.h"
#include "scene/tile_content.h"

namespace tellurion::scene {

struct TileJob;

/// What a forest knows of a tile. What every update reads stands together: it is read while the memory is cold.
struct TileRecord final : TileFacts {
  std::uint64_t lastUse = 0;  ///< number of the update that used it last
  std::shared_ptr<const TileContent> content;
  double madeFor = 1.0;                   ///< the exaggeration that the facts were made for
  std::uint64_t visibility = 0;           ///< number of the layers in sight that facts.texel_m was made for
  std::uint64_t residency = 0;            ///< number of what was on the GPU when facts.copy_bytes was asked for
  std::uint64_t arrivals = 0;             ///< on the GPU, so far, at that time
  std::uint32_t drawnAt = 0;              ///< where FrameTiles drew it last
  bool isUnused = false;                  ///< it is among the UnusedRecords, between olderUnused and newerUnused
  std::array<TileRecord*, 4> children{};  ///< their records, once they were asked for
  tiling::TileId id;
  std::uint64_t lastWanted = 0;  ///< number of the update that asked for it last
  std::shared_ptr<TileJob> job;  ///< asked for and not here yet
  TileRecord* olderUnused = nullptr;
  TileRecord* newerUnused = nullptr;
};

}  // namespace tellurion::scene
