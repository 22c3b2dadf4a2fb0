#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "pyramid/database_meta.h"
#include "pyramid/tile_index.h"
#include "pyramid/tile_record.h"

namespace tellurion::pyramid {

// A tile database as objects of a web server or a bucket (docs/remote-databases.md): one that tells what there is, and
// one a tile. All that is read is safe on untrusted bytes.

/// Its name in the folder.
inline constexpr std::string_view kContentsObject = "contents";

/// What the first object tells.
struct ObjectContents {
  DatabaseMeta meta;     ///< without sources and keys: they name places of the machine that built it
  std::string revision;  ///< eight hexadecimal digits; of other tiles, others
  TileIndex index;
};

std::vector<std::byte> encodedContents(const ObjectContents& contents);
/// where: for messages.
io::Result<ObjectContents> decodedContents(std::span<const std::byte> bytes, const std::string& where);

/// "1a2b3c4d/5/2/17/9": revision, level, root, x, y.
std::string objectName(const std::string& revision, const tiling::TileId& id);
std::vector<std::byte> encodedObject(const TileRecord& record, raster::Kind kind);
/// Fails where it is not this tile, or its checksum is wrong.
io::Result<TileRecord> decodedObject(std::span<const std::byte> bytes, const tiling::TileId& id, raster::Kind kind);

struct ExportedObjects {
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  std::string revision;
};
using ObjectSink = std::function<void(std::uint64_t done, std::uint64_t total)>;
/// Writes a finished database's objects into a folder that is new, empty or an earlier export's. The tiles of a new
/// revision come first, then the contents, then the tiles of the old revision go; nothing else there is touched:
/// whoever reads meanwhile has one or the other. What an export that was stopped has written is used by the next.
io::Result<ExportedObjects> exportObjects(const std::filesystem::path& database, const std::filesystem::path& folder,
                                          const ObjectSink& progress = {}, const std::stop_token& stop = {});

}  // namespace tellurion::pyramid
