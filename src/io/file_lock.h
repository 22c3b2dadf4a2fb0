#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "io/failure.h"

namespace tellurion::io {

/// A file that one program at a time holds, on this machine or on others that share the file system. The system lets go
/// of it when its holder ends, however it ends, so there is nothing to time out. Move-only; any thread.
class FileLock {
 public:
  /// Nothing: another program holds it. Makes the file where there is none. Fails where the folder is not there, cannot
  /// be written, or its file system knows no locks.
  static Result<std::optional<FileLock>> tryTake(const std::filesystem::path& path);

  /// Lets go, and notes that it was done in good order.
  ~FileLock();
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&&) = delete;

  /// "process 123 on HOST", which held the lock and ended without letting go of it; empty: nobody did.
  const std::string& leftBy() const { return leftBy_; }

 private:
  explicit FileLock(int file);
  int file_;
  std::string leftBy_;
};

}  // namespace tellurion::io
