#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "raster/tile_source.h"

namespace tellurion::pyramid {

struct LevelSummary {
  int level = 0;
  std::uint64_t tiles = 0;
  std::uint64_t payloadBytes = 0;
  geo::Angle spacing;  ///< mean distance between samples, on the unit sphere
};

/// What `info` tells beyond TileSourceInfo. Costs a walk over the table of tiles (not their payloads).
struct PyramidSummary {
  double heightStep_m = 0.0;  ///< heights are multiples of it; 0: 32-bit floating point, kept exactly
  double fillVoids_m = 0.0;   ///< over how far at most voids were filled (BuildOptions); 0: they were not
  double maxError_m = 0.0;    ///< how far heights may be off what the inputs say (BuildOptions); 0: not asked for
  std::uint64_t fileBytes = 0;
  std::vector<LevelSummary> levels;  ///< only levels that hold tiles, coarsest first
  std::vector<std::string> sources;  ///< the inputs, as they were named, bottom first
};

/// A finished tile database (docs/tile-database.md), read only. Safe on untrusted files: every size, range and checksum
/// is checked before it is believed. Thread-safe: each thread that asks at the same time gets a connection of its own.
class PyramidReader final : public raster::TileSource {
 public:
  /// Fails when there is no such file, it is no tile database, of another format version, damaged, or not finished.
  static io::Result<std::shared_ptr<const PyramidReader>> open(const std::filesystem::path& path);
  ~PyramidReader() override;

  const raster::TileSourceInfo& info() const override;
  /// Reads and decodes. Fails on a wrong checksum, a payload that does not decode, or a root that is not stored though
  /// a child of it is; nothing where no tile is stored. That a deeper tile is missing only its parent can tell.
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override;
  /// Reads the row and checks it, payload included, without decoding that.
  io::Result<raster::TilePresence> lookUp(const tiling::TileId& id) const override;
  /// As TileDatabase::depths.
  io::Result<std::optional<raster::Raster<float>>> depths(const tiling::TileId& id) const;
  io::Result<PyramidSummary> summary() const;

 private:
  struct State;
  explicit PyramidReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::pyramid
