#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_map>

#include "io/cache_file.h"
#include "io/failure.h"

namespace tellurion::io {

/// What has come from servers, kept on disk within a budget. Reads wait for the disk; writes are gathered and done on a
/// thread of its own, all of them before destruction ends. Never fails: a file that cannot be used is told of once
/// (`warn`, on any thread) and then nothing is kept; a damaged one is moved aside and begun anew. Thread-safe.
class ByteCache {
 public:
  using Warn = std::function<void(const Failure&)>;

  ByteCache(std::filesystem::path path, std::uint64_t budget, Warn warn);
  ~ByteCache();
  ByteCache(const ByteCache&) = delete;
  ByteCache& operator=(const ByteCache&) = delete;

  std::optional<CacheEntry> find(const CacheKey& key);
  void keep(const CacheKey& key, CacheEntry entry);
  void renew(const CacheKey& key, UnixSeconds fetched, UnixSeconds expires);
  /// From now on it is not found, and it goes from the file with the next write.
  void forget(const CacheKey& key);
  /// Of the file, as of the last write of this process.
  std::uint64_t bytes() const;

 private:
  // An entry to write, new times for one that is there, or its end.
  struct Change {
    std::optional<CacheEntry> entry;
    UnixSeconds fetched = 0;
    UnixSeconds expires = 0;
    bool isForgotten = false;
    std::uint64_t size() const;
  };
  using Changes = std::map<CacheKey, Change>;
  using Uses = std::unordered_map<std::int64_t, std::int64_t>;  // row: when

  void open();
  Result<void> openFile();
  void replaceDamaged(const Failure& why);
  std::uint64_t limit() const;
  void trim();
  void run();
  void write(const Changes& changes, const Uses& uses);
  Result<void> tryWrite(const Changes& changes, const Uses& uses);
  void tell(Failure failure);

  const std::filesystem::path path_;
  const std::uint64_t budget_;
  const Warn warn_;

  std::mutex readMutex_;  // taken before queueMutex_ where both are
  std::optional<CacheFile> reader_;
  std::optional<CacheFile> writer_;  // the thread's
  bool told_ = false;                // the thread's
  std::chrono::steady_clock::time_point writeAgain_;

  mutable std::mutex queueMutex_;
  std::condition_variable wake_;
  Changes pending_;
  Changes writing_;  // still to be found while the thread works on them
  Uses uses_;
  std::uint64_t pendingBytes_ = 0;
  std::uint64_t bytes_ = 0;
  std::optional<Failure> damage_;  // found by a reader
  bool stopping_ = false;

  std::thread thread_;
};

}  // namespace tellurion::io
