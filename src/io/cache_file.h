#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "io/http_headers.h"
#include "io/resources.h"
#include "io/sqlite.h"

namespace tellurion::io {

/// Which resource: the same URL may stand for different things in two data sets.
struct CacheKey {
  std::string dataset;
  std::string url;
  friend auto operator<=>(const CacheKey&, const CacheKey&) = default;
};

/// What is kept of a resource.
struct CacheEntry {
  std::shared_ptr<const Resource> resource;  ///< null: the server said that there is nothing
  std::string etag;
  std::string lastModified;
  UnixSeconds fetched = 0;
  UnixSeconds expires = 0;  ///< good without asking the server until then
};

/// One SQLite file of cache entries; docs/online.md has its tables. Move-only, one thread at a time; any number of
/// connections and processes may have it open. A failure with Code::corrupt says that the file is of no more use.
class CacheFile {
 public:
  /// The log beside the file is written into it when it has so many bytes.
  static constexpr std::int64_t kLog_bytes = 4 << 20;

  static Result<CacheFile> open(const std::filesystem::path& path, SqliteConnection::Mode mode,
                                std::int64_t logBytes = kLog_bytes);

  struct Found {
    std::int64_t row = 0;
    CacheEntry entry;
  };
  /// Nothing: not there, or damaged.
  Result<std::optional<Found>> find(const CacheKey& key);
  /// Replaces what is there.
  Result<void> write(const CacheKey& key, const CacheEntry& entry, std::int64_t used_ms);
  /// The server says that it is still good.
  Result<void> renew(const CacheKey& key, UnixSeconds fetched, UnixSeconds expires);
  /// Nothing happens where it is not there.
  Result<void> erase(const CacheKey& key);
  Result<void> markUsed(std::int64_t row, std::int64_t used_ms);
  /// Takes out the least recently used until the file, free pages aside, has at most so many bytes.
  Result<void> shrinkTo(std::uint64_t bytes);
  /// Of the file, free pages aside, as of this connection's transaction.
  Result<std::uint64_t> bytes() const;
  /// Reads everything there is: whether the file is sound as a whole.
  Result<bool> isSound() const;

  Result<void> begin() { return connection_.execute("BEGIN IMMEDIATE"); }
  Result<void> commit() { return connection_.execute("COMMIT"); }
  void rollback() { static_cast<void>(connection_.execute("ROLLBACK")); }
  /// Gives all free pages back to the file system.
  Result<void> releaseFreePages();

 private:
  explicit CacheFile(SqliteConnection connection) : connection_(std::move(connection)) {}
  Result<void> eraseRow(std::int64_t row);
  Result<SqliteStatement*> prepared(std::optional<SqliteStatement>& slot, std::string_view sql);

  SqliteConnection connection_;
  std::optional<SqliteStatement> find_, writeEntry_, writeBody_, eraseBody_, renew_, markUsed_, oldest_, eraseEntry_,
      row_;
};

}  // namespace tellurion::io
