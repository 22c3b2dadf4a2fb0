#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/sqlite.h"
#include "pyramid/database_meta.h"
#include "pyramid/tile_record.h"
#include "raster/tile_source.h"

namespace tellurion::pyramid {

/// Where an unfinished build is: every tile of deeper levels and, of this level, every row up to `row` is done.
struct BuildPosition {
  int level = 0;
  std::int64_t row = 0;
  std::uint64_t done = 0;  ///< candidate tiles looked at so far

  friend bool operator==(const BuildPosition&, const BuildPosition&) = default;
};

/// A tile database file, finished or not. Move-only, one thread only. Checks what it reads.
class TileDatabase {
 public:
  static io::Result<TileDatabase> open(const std::filesystem::path& path, io::SqliteConnection::Mode mode);
  /// A new file, or one that a build left before its first commit; nothing else may be there.
  static io::Result<TileDatabase> create(const std::filesystem::path& path, const DatabaseMeta& meta,
                                         const BuildPosition& start);
  /// Whether the file holds nothing at all yet: killed before its first commit.
  static io::Result<bool> isBlank(const std::filesystem::path& path);

  const DatabaseMeta& meta() const { return meta_; }
  io::Result<void> writeMeta(const DatabaseMeta& meta);

  io::Result<std::optional<BuildPosition>> position() const;
  io::Result<void> writePosition(const std::optional<BuildPosition>& position);

  /// A wrong checksum is a failure.
  io::Result<std::optional<TileRecord>> read(const tiling::TileId& id);
  io::Result<bool> contains(const tiling::TileId& id);
  io::Result<void> write(const TileRecord& record);
  /// Of each sample, gutter included, the level of the data that it comes from where that is coarser than the tile; NaN
  /// where it is not. Nothing: of no sample it is.
  io::Result<std::optional<raster::Raster<float>>> depths(const tiling::TileId& id);

  io::Result<void> begin() { return connection_.execute("BEGIN IMMEDIATE"); }
  io::Result<void> commit() { return connection_.execute("COMMIT"); }
  void rollback() { static_cast<void>(connection_.execute("ROLLBACK")); }
  const io::SqliteConnection& connection() const { return connection_; }

 private:
  TileDatabase(io::SqliteConnection connection, DatabaseMeta meta)
      : connection_(std::move(connection)), meta_(std::move(meta)) {}
  io::Result<void> writeDepths(const TileRecord& record);
  io::Result<io::SqliteStatement*> prepared(std::optional<io::SqliteStatement>& slot, std::string_view sql);

  io::SqliteConnection connection_;
  DatabaseMeta meta_;
  std::optional<io::SqliteStatement> read_;
  std::optional<io::SqliteStatement> contains_;
  std::optional<io::SqliteStatement> write_;
  std::optional<io::SqliteStatement> readDepths_;
  std::optional<io::SqliteStatement> writeDepths_;
  std::optional<io::SqliteStatement> removeDepths_;
};

/// What is stored of a tile's depths; nothing where it is empty.
std::vector<std::byte> encodedDepths(const raster::Raster<float>& depths);

/// The columns that `recordFrom` expects, in order.
inline constexpr std::string_view kTileColumns =
    "id, level, root, x, y, min_m, max_m, error_m, child_mask, children, checksum, payload";

/// A row that is at columns kTileColumns of `row`; `where` names the file. Fails when its columns contradict each
/// other, a value is out of its range or the checksum is wrong.
io::Result<TileRecord> recordFrom(const io::SqliteStatement& row, raster::Kind kind, const std::string& where);

}  // namespace tellurion::pyramid
