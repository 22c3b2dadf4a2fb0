#include "io/cache_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <system_error>
#include <utility>
#include <vector>

namespace tellurion::io {
namespace {

constexpr std::int64_t kApplicationId = 0x54436163;  // "TCac"
constexpr std::int64_t kVersion = 1;
// Rows taken out between two looks at the file's size.
constexpr int kEvictedAtOnce = 32;

constexpr std::array kTables{
    "CREATE TABLE IF NOT EXISTS entries (row INTEGER PRIMARY KEY, dataset TEXT NOT NULL, url TEXT NOT NULL,"
    " type TEXT NOT NULL, etag TEXT NOT NULL, modified TEXT NOT NULL, fetched INTEGER NOT NULL,"
    " expires INTEGER NOT NULL, used_ms INTEGER NOT NULL, size INTEGER, checksum INTEGER NOT NULL, UNIQUE (dataset, "
    "url))",
    "CREATE INDEX IF NOT EXISTS entries_by_use ON entries (used_ms)",
    "CREATE TABLE IF NOT EXISTS bodies (row INTEGER PRIMARY KEY, bytes BLOB NOT NULL)",
};

// FNV-1a, 64 bits, of all but the times: against bytes that went bad on the disk, not against anybody.
class Checksum {
 public:
  void add(std::span<const std::byte> bytes) {
    for (const std::byte b : bytes) {
      hash_ ^= std::to_integer<std::uint64_t>(b);
      hash_ *= 0x100000001b3;
    }
  }
  std::int64_t value() const { return static_cast<std::int64_t>(hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

std::int64_t checksumOf(const CacheKey& key, const CacheEntry& entry) {
  Checksum sum;
  const std::string type = entry.resource ? entry.resource->contentType : "";
  const std::string texts = fmt::format("{}\n{}\n{}\n{}\n{}\n{}", entry.resource ? "there" : "nothing", key.dataset,
                                        key.url, type, entry.etag, entry.lastModified);
  sum.add(std::as_bytes(std::span(texts)));
  if (entry.resource) sum.add(entry.resource->bytes);
  return sum.value();
}

Result<void> createTables(const SqliteConnection& connection) {
  // Two processes may come here at once.
  Result<void> done = connection.execute("BEGIN IMMEDIATE");
  for (const char* const table : kTables)
    if (done) done = connection.execute(table);
  if (done) done = connection.execute(fmt::format("PRAGMA application_id = {}", kApplicationId));
  if (done) done = connection.execute(fmt::format("PRAGMA user_version = {}", kVersion));
  if (done) return connection.execute("COMMIT");
  static_cast<void>(connection.execute("ROLLBACK"));
  return done;
}

// Blank files become caches; what is something else is not ours to write into.
Result<void> prepareFile(const SqliteConnection& connection, SqliteConnection::Mode mode, std::int64_t logBytes) {
  const Result<std::int64_t> application = connection.integer("PRAGMA application_id");
  if (!application) return tl::unexpected(application.error());
  const Result<std::int64_t> version = connection.integer("PRAGMA user_version");
  if (!version) return tl::unexpected(version.error());
  if (*application == kApplicationId && *version != kVersion)
    return fail(Failure::Code::corrupt, fmt::format("is a cache of version {}, not {}", *version, kVersion),
                connection.path());
  if (*application != kApplicationId) {
    const Result<std::int64_t> tables = connection.integer("SELECT count(*) FROM sqlite_schema");
    if (!tables) return tl::unexpected(tables.error());
    if (*tables != 0)
      return fail(Failure::Code::unsupported, "is a database of something else; name another file", connection.path());
  }
  if (mode == SqliteConnection::Mode::read) return {};
  // Must come before the first table; keeps a file that has become smaller able to give its pages back.
  if (*application != kApplicationId)
    if (const auto done = connection.execute("PRAGMA auto_vacuum = INCREMENTAL"); !done) return done;
  if (const auto done = connection.execute("PRAGMA journal_mode = WAL"); !done) return done;
  const std::int64_t pageSize = connection.integer("PRAGMA page_size").value_or(4096);
  for (const std::string& setting : {std::string("PRAGMA synchronous = NORMAL"),
                                     fmt::format("PRAGMA wal_autocheckpoint = {}", logBytes / pageSize + 1),
                                     fmt::format("PRAGMA journal_size_limit = {}", logBytes)})
    if (const auto done = connection.execute(setting); !done) return done;
  return *application == kApplicationId ? Result<void>{} : createTables(connection);
}

// Only for who made it: what a server shows to one account is nobody else's. The files beside it take its mode.
void makePrivate(const std::filesystem::path& path) {
  constexpr mode_t kMine = S_IRUSR | S_IWUSR;
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kMine);
  if (file < 0) return;  // SQLite tells why, and what cannot be written may still be read
  ::close(file);
  // One of an earlier program; somebody else's stays as it is.
  for (const char* const ending : {"", "-wal", "-shm"}) {
    std::error_code ignored;
    std::filesystem::permissions(path.string() + ending,
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_write, ignored);
  }
}

}  // namespace

Result<CacheFile> CacheFile::open(const std::filesystem::path& path, SqliteConnection::Mode mode,
                                  std::int64_t logBytes) {
  if (mode == SqliteConnection::Mode::create) makePrivate(path);
  Result<SqliteConnection> connection = SqliteConnection::open(path, mode);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto ready = prepareFile(*connection, mode, logBytes); !ready) return tl::unexpected(ready.error());
  return CacheFile(std::move(*connection));
}

Result<SqliteStatement*> CacheFile::prepared(std::optional<SqliteStatement>& slot, std::string_view sql) {
  if (!slot) {
    Result<SqliteStatement> statement = connection_.prepare(sql);
    if (!statement) return tl::unexpected(statement.error());
    slot = std::move(*statement);
  }
  slot->reset();
  return &*slot;
}

Result<std::optional<CacheFile::Found>> CacheFile::find(const CacheKey& key) {
  const auto statement =
      prepared(find_,
               "SELECT e.row, e.type, e.etag, e.modified, e.fetched, e.expires, e.size, e.checksum, b.bytes"
               " FROM entries AS e LEFT JOIN bodies AS b ON b.row = e.row WHERE e.dataset = ?1 AND e.url = ?2");
  if (!statement) return tl::unexpected(statement.error());
  SqliteStatement& row = **statement;
  const Result<bool> there = row.bind(1, key.dataset).bind(2, key.url).step();
  if (!there) return tl::unexpected(there.error());
  if (!*there) return std::nullopt;
  Found found{.row = row.integer(0)};
  found.entry.etag = row.text(2);
  found.entry.lastModified = row.text(3);
  found.entry.fetched = row.integer(4);
  found.entry.expires = row.integer(5);
  if (!row.isNull(6)) {
    const std::span<const std::byte> bytes = row.blob(8);
    found.entry.resource =
        std::make_shared<const Resource>(Resource{.bytes = {bytes.begin(), bytes.end()}, .contentType = row.text(1)});
  }
  const bool sound = checksumOf(key, found.entry) == row.integer(7);
  row.reset();  // an open statement would hold back the log's checkpoints
  if (!sound) return std::nullopt;
  return found;
}

Result<void> CacheFile::write(const CacheKey& key, const CacheEntry& entry, std::int64_t used_ms) {
  const auto upsert = prepared(
      writeEntry_,
      "INSERT INTO entries (dataset, url, type, etag, modified, fetched, expires, used_ms, size, checksum)"
      " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10) ON CONFLICT (dataset, url) DO UPDATE SET type = excluded.type,"
      " etag = excluded.etag, modified = excluded.modified, fetched = excluded.fetched, expires = excluded.expires,"
      " used_ms = excluded.used_ms, size = excluded.size, checksum = excluded.checksum RETURNING row");
  if (!upsert) return tl::unexpected(upsert.error());
  SqliteStatement& insert = **upsert;
  insert.bind(1, key.dataset).bind(2, key.url).bind(4, entry.etag).bind(5, entry.lastModified);
  insert.bind(6, entry.fetched).bind(7, entry.expires).bind(8, used_ms).bind(10, checksumOf(key, entry));
  if (entry.resource) {
    insert.bind(3, entry.resource->contentType).bind(9, static_cast<std::int64_t>(entry.resource->bytes.size()));
  } else {
    insert.bind(3, std::string_view("")).bindNull(9);
  }
  const Result<bool> inserted = insert.step();
  if (!inserted) return tl::unexpected(inserted.error());
  const std::int64_t row = *inserted ? insert.integer(0) : 0;
  insert.reset();
  if (!entry.resource) {
    const auto erase = prepared(eraseBody_, "DELETE FROM bodies WHERE row = ?1");
    if (!erase) return tl::unexpected(erase.error());
    return (*erase)->bind(1, row).run();
  }
  const auto body = prepared(writeBody_, "INSERT OR REPLACE INTO bodies (row, bytes) VALUES (?1, ?2)");
  if (!body) return tl::unexpected(body.error());
  return (*body)->bind(1, row).bind(2, std::span<const std::byte>(entry.resource->bytes)).run();
}

Result<void> CacheFile::renew(const CacheKey& key, UnixSeconds fetched, UnixSeconds expires) {
  const auto update = prepared(renew_, "UPDATE entries SET fetched = ?3, expires = ?4 WHERE dataset = ?1 AND url = ?2");
  if (!update) return tl::unexpected(update.error());
  return (*update)->bind(1, key.dataset).bind(2, key.url).bind(3, fetched).bind(4, expires).run();
}

Result<void> CacheFile::erase(const CacheKey& key) {
  const auto find = prepared(row_, "SELECT row FROM entries WHERE dataset = ?1 AND url = ?2");
  if (!find) return tl::unexpected(find.error());
  const Result<bool> there = (*find)->bind(1, key.dataset).bind(2, key.url).step();
  if (!there) return tl::unexpected(there.error());
  if (!*there) return {};
  const std::int64_t row = (*find)->integer(0);
  (*find)->reset();
  return eraseRow(row);
}

Result<void> CacheFile::eraseRow(std::int64_t row) {
  const auto body = prepared(eraseBody_, "DELETE FROM bodies WHERE row = ?1");
  const auto entry = prepared(eraseEntry_, "DELETE FROM entries WHERE row = ?1");
  if (!body || !entry) return tl::unexpected((body ? entry : body).error());
  if (const auto done = (*body)->bind(1, row).run(); !done) return done;
  return (*entry)->bind(1, row).run();
}

Result<void> CacheFile::markUsed(std::int64_t row, std::int64_t used_ms) {
  const auto update = prepared(markUsed_, "UPDATE entries SET used_ms = ?2 WHERE row = ?1 AND used_ms < ?2");
  if (!update) return tl::unexpected(update.error());
  return (*update)->bind(1, row).bind(2, used_ms).run();
}

Result<void> CacheFile::shrinkTo(std::uint64_t bytes) {
  const Result<std::uint64_t> before = this->bytes();
  if (!before) return tl::unexpected(before.error());
  if (*before <= bytes) return {};
  while (true) {
    const auto oldest = prepared(oldest_, "SELECT row FROM entries ORDER BY used_ms LIMIT ?1");
    if (!oldest) return tl::unexpected(oldest.error());
    std::vector<std::int64_t> rows;
    (*oldest)->bind(1, std::int64_t{kEvictedAtOnce});
    Result<bool> more = (*oldest)->step();
    for (; more && *more; more = (*oldest)->step())
      rows.push_back((*oldest)->integer(0));
    if (!more) return tl::unexpected(more.error());
    if (rows.empty()) return {};
    for (const std::int64_t row : rows) {
      if (const auto done = eraseRow(row); !done) return done;
      const Result<std::uint64_t> left = this->bytes();
      if (!left) return tl::unexpected(left.error());
      if (*left <= bytes) return {};
    }
  }
}

Result<std::uint64_t> CacheFile::bytes() const {
  const Result<std::int64_t> size = connection_.integer("PRAGMA page_size");
  const Result<std::int64_t> pages = connection_.integer("PRAGMA page_count");
  const Result<std::int64_t> unused = connection_.integer("PRAGMA freelist_count");
  if (!size || !pages || !unused) return tl::unexpected((!size ? size : !pages ? pages : unused).error());
  return static_cast<std::uint64_t>(*size * (*pages - *unused));
}

Result<bool> CacheFile::isSound() const {
  auto check = connection_.prepare("PRAGMA quick_check(1)");
  if (!check) return tl::unexpected(check.error());
  const Result<bool> row = check->step();
  if (!row) return tl::unexpected(row.error());
  return *row && check->text(0) == "ok";
}

Result<void> CacheFile::releaseFreePages() {
  const Result<void> done = connection_.execute("PRAGMA incremental_vacuum");
  return done ? connection_.execute("PRAGMA wal_checkpoint(TRUNCATE)") : done;
}

}  // namespace tellurion::io
