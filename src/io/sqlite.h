#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "io/failure.h"

struct sqlite3;
struct sqlite3_stmt;

namespace tellurion::io {

/// A prepared statement. Move-only, one thread only; must not outlive its connection. Binding positions count from 1,
/// columns from 0. Text and blobs are copied on binding.
class SqliteStatement {
 public:
  SqliteStatement& bind(int position, std::int64_t value);
  SqliteStatement& bind(int position, double value);  ///< NaN becomes NULL
  SqliteStatement& bind(int position, std::string_view value);
  SqliteStatement& bind(int position, std::span<const std::byte> value);
  SqliteStatement& bindNull(int position);

  /// True: there is a row to read. After false or a failure the statement is reset and its bindings are gone.
  Result<bool> step();
  /// Runs to the end, rows ignored.
  Result<void> run();
  void reset();

  bool isNull(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;  ///< NULL reads as NaN
  std::string text(int column) const;
  std::span<const std::byte> blob(int column) const;  ///< valid until the next step or reset

 private:
  friend class SqliteConnection;
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const;
  };
  SqliteStatement(sqlite3_stmt* statement, std::string where) : statement_(statement), where_(std::move(where)) {}
  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
  std::string where_;
};

/// A connection to an SQLite file, set up so that a hostile file can do no more than fail: no functions from the
/// schema, cells checked when pages are read, no value above 64 MiB. Move-only, one thread only.
class SqliteConnection {
 public:
  enum class Mode { read, write, create };
  static Result<SqliteConnection> open(const std::filesystem::path& path, Mode mode);

  Result<SqliteStatement> prepare(std::string_view sql) const;
  Result<void> execute(std::string_view sql) const;
  Result<std::int64_t> integer(std::string_view sql) const;  ///< first column of the first row; 0 without a row
  const std::string& path() const { return path_; }
  /// Makes statements that run right now fail soon. From any thread.
  void interrupt() const;

 private:
  struct Closer {
    void operator()(sqlite3* database) const;
  };
  SqliteConnection(sqlite3* database, std::string path) : database_(database), path_(std::move(path)) {}
  std::unique_ptr<sqlite3, Closer> database_;
  std::string path_;
};

}  // namespace tellurion::io
