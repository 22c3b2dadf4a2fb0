#include "io/sqlite.h"

#include <sqlite3.h>

#include <cmath>
#include <limits>
#include <string>
#include <system_error>

namespace tellurion::io {
namespace {

constexpr int kBusyTimeout_ms = 10'000;
constexpr int kLargestValue = 64 << 20;

using Code = Failure::Code;

/// What the system said of the database's file: a quota, a file too large, a device that fails. (Of a failed commit
/// sqlite3_system_errno() knows nothing.) Empty: nothing, or of the journal.
std::string causeOf(sqlite3* database) {
  int cause = 0;
  const bool isKnown =
      database != nullptr && sqlite3_file_control(database, "main", SQLITE_FCNTL_LAST_ERRNO, &cause) == SQLITE_OK;
  return !isKnown || cause == 0 ? std::string() : ": " + std::generic_category().message(cause);
}

std::int64_t pragmaOf(sqlite3* database, const char* sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database, sql, -1, &statement, nullptr) != SQLITE_OK) return 0;
  const std::int64_t value = sqlite3_step(statement) == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : 0;
  sqlite3_finalize(statement);
  return value;
}

/// SQLite has one code for a full disk and for a file of as many pages as are allowed. What did not fit is taken back
/// by now, so that the file is nearly full.
bool isOutOfPages(sqlite3* database) {
  const std::int64_t most = pragmaOf(database, "PRAGMA max_page_count");
  return most > 0 && pragmaOf(database, "PRAGMA page_count") > most - most / 100;
}

Failure failureOf(int resultCode, sqlite3* database, const std::string& where) {
  const std::string detail = database != nullptr ? sqlite3_errmsg(database) : sqlite3_errstr(resultCode);
  const auto failure = [&](Code code, const std::string& message) { return Failure{code, message, where}; };
  switch (resultCode & 0xff) {
    case SQLITE_NOTADB:
      return failure(Code::corrupt, "not a database (no SQLite file)");
    case SQLITE_CORRUPT:
    case SQLITE_FORMAT:
      return failure(Code::corrupt, "the database file is damaged (" + detail + ")");
    case SQLITE_TOOBIG:
      return failure(Code::corrupt, "the database holds a value larger than any it should");
    case SQLITE_FULL:
      if (isOutOfPages(database)) {
        return failure(Code::ioError,
                       "the file holds all the pages that a database can have; what was committed is safe: spread the "
                       "data over several databases");
      }
      return failure(Code::ioError,
                     "the disk is full; nothing is lost: free some space and run the same command again");
    case SQLITE_IOERR:
      return failure(Code::ioError, "reading or writing failed (" + detail + causeOf(database) +
                                        "); what was committed is safe, the same command goes on from there");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return failure(Code::ioError, "another program is writing this database; wait for it to end");
    case SQLITE_CANTOPEN:
      return failure(Code::notFound, "cannot be opened (" + detail + ")");
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return failure(Code::ioError, "may not be written (" + detail + ")");
    case SQLITE_NOMEM:
      return failure(Code::ioError, "out of memory");
    default:
      return failure(Code::corrupt, "the database cannot be used (" + detail + ")");
  }
}

Failure failureOf(sqlite3_stmt* statement, int resultCode, const std::string& where) {
  return failureOf(resultCode, sqlite3_db_handle(statement), where);
}

int flagsOf(SqliteConnection::Mode mode) {
  switch (mode) {
    case SqliteConnection::Mode::read:
      return SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX;
    case SqliteConnection::Mode::write:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX;
    case SqliteConnection::Mode::create:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  }
  return SQLITE_OPEN_READONLY;
}

}  // namespace

void SqliteStatement::Finalizer::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}
void SqliteConnection::Closer::operator()(sqlite3* database) const {
  sqlite3_close_v2(database);
}

SqliteStatement& SqliteStatement::bind(int position, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), position, value);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int position, double value) {
  if (std::isnan(value)) return bindNull(position);
  sqlite3_bind_double(statement_.get(), position, value);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int position, std::string_view value) {
  sqlite3_bind_text64(statement_.get(), position, value.data(), value.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}

SqliteStatement& SqliteStatement::bind(int position, std::span<const std::byte> value) {
  if (value.empty()) {
    sqlite3_bind_zeroblob(statement_.get(), position, 0);
  } else {
    sqlite3_bind_blob64(statement_.get(), position, value.data(), value.size(), SQLITE_TRANSIENT);
  }
  return *this;
}

SqliteStatement& SqliteStatement::bindNull(int position) {
  sqlite3_bind_null(statement_.get(), position);
  return *this;
}

Result<bool> SqliteStatement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) {
    reset();
    return false;
  }
  const Failure failure = failureOf(statement_.get(), code, where_);
  reset();
  return tl::unexpected(failure);
}

Result<void> SqliteStatement::run() {
  while (true) {
    const auto row = step();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return {};
  }
}

void SqliteStatement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
}

bool SqliteStatement::isNull(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}
std::int64_t SqliteStatement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double SqliteStatement::real(int column) const {
  if (isNull(column)) return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(statement_.get(), column);
}

std::string SqliteStatement::text(int column) const {
  const std::span<const std::byte> bytes = blob(column);
  std::string text(bytes.size(), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i)
    text[i] = static_cast<char>(bytes[i]);
  return text;
}

std::span<const std::byte> SqliteStatement::blob(int column) const {
  const void* data = sqlite3_column_blob(statement_.get(), column);
  const int size = sqlite3_column_bytes(statement_.get(), column);
  if (data == nullptr || size <= 0) return {};
  return {static_cast<const std::byte*>(data), static_cast<std::size_t>(size)};
}

Result<SqliteConnection> SqliteConnection::open(const std::filesystem::path& path, Mode mode) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &raw, flagsOf(mode), nullptr);
  SqliteConnection connection(raw, path.string());
  if (code != SQLITE_OK) return tl::unexpected(failureOf(code, raw, connection.path_));
  sqlite3_extended_result_codes(raw, 1);
  sqlite3_busy_timeout(raw, kBusyTimeout_ms);
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, kLargestValue);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(raw, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  const auto checked = connection.execute("PRAGMA cell_size_check = ON");
  if (!checked) return tl::unexpected(checked.error());
  return connection;
}

void SqliteConnection::interrupt() const {
  sqlite3_interrupt(database_.get());
}

Result<SqliteStatement> SqliteConnection::prepare(std::string_view sql) const {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr);
  if (code != SQLITE_OK) return tl::unexpected(failureOf(code, database_.get(), path_));
  return SqliteStatement(statement, path_);
}

Result<void> SqliteConnection::execute(std::string_view sql) const {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected(statement.error());
  return statement->run();
}

Result<std::int64_t> SqliteConnection::integer(std::string_view sql) const {
  auto statement = prepare(sql);
  if (!statement) return tl::unexpected(statement.error());
  const auto row = statement->step();
  if (!row) return tl::unexpected(row.error());
  return *row ? statement->integer(0) : 0;
}

}  // namespace tellurion::io
