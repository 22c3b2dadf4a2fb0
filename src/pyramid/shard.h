#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "pyramid/build_plan.h"
#include "pyramid/tile_maker.h"

namespace tellurion::pyramid {

/// A part of a build in a file of its own (docs/tile-database.md, "Shards"): an unfinished tile database with two
/// tables more. `shard` says what was asked for and which part this is; `pieces` lists what the part was made in,
/// pieces without data too.

/// Whether the file is, or is to become, a shard.
bool isShard(const TileDatabase& database);

/// Makes a database that holds nothing a shard. The folder that relative names start from is the current one.
io::Result<void> makeShard(TileDatabase& database, const BuildOptions& options, const tiling::TileId& part);
io::Result<void> listPiece(TileDatabase& database, const tiling::TileId& piece, std::uint64_t candidates);
io::Result<void> finishShard(TileDatabase& database);

/// What the shard's build was asked for, without an output, and where relative names start from. Safe on hostile files.
struct ShardRequest {
  BuildOptions options;
  std::string folder;
};
io::Result<ShardRequest> requestOf(const std::filesystem::path& shard);

/// The finished shards of one build. One thread only.
class ShardSet {
 public:
  /// Each part of the plan must be there once, and nothing else.
  static io::Result<ShardSet> open(std::span<const std::filesystem::path> shards, const BuildPlan& plan,
                                   std::span<const tiling::TileId> parts);

  /// The tiles of a piece (BuildPlan::startLevel) as TileMaker made them, in that order. Quick where the pieces of a
  /// part are asked for one after the other.
  io::Result<MadeTiles> piece(const tiling::TileId& id);

 private:
  explicit ShardSet(int deepestLevel) : deepestLevel_(deepestLevel) {}
  io::Result<void> readFamily(const tiling::TileId& id, MadeTiles& made);

  int deepestLevel_;
  int partLevel_ = 0;
  std::unordered_map<tiling::TileId, std::filesystem::path, tiling::TileIdHash> paths_;
  std::optional<TileDatabase> open_;
  tiling::TileId openPart_;
};

}  // namespace tellurion::pyramid
