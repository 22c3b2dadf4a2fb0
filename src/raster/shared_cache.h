#pragma once

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <utility>

#include "io/failure.h"

namespace tellurion::raster {

/// Values that take time to make, kept by key up to a budget in bytes; the one unused for longest goes first, but none
/// that somebody holds, since that would free nothing. Who asks for what another thread is making waits for it. A null
/// value is a value: there is nothing. Failures are not kept. Thread-safe.
template <class Key, class Value, class Hash>
class SharedCache {
 public:
  using Pointer = std::shared_ptr<const Value>;

  explicit SharedCache(std::uint64_t budgetBytes) : budget_(budgetBytes) {}

  /// The value of `key`; make() -> io::Result<Pointer> where there is none, bytesOf(const Value&) for its size.
  template <class Make, class BytesOf>
  io::Result<Pointer> get(const Key& key, const Make& make, const BytesOf& bytesOf) {
    std::unique_lock lock(mutex_);
    for (;;) {
      const auto found = entries_.find(key);
      if (found == entries_.end()) break;
      if (!found->second.making) {
        uses_.splice(uses_.begin(), uses_, found->second.use);
        return found->second.value;
      }
      made_.wait(lock);
    }
    entries_.emplace(key, Entry{});
    lock.unlock();
    io::Result<Pointer> value = make();
    lock.lock();
    if (value) {
      keep(key, *value, kEntryBytes + (*value ? bytesOf(**value) : 0));
    } else {
      entries_.erase(key);
    }
    made_.notify_all();
    return value;
  }

  /// What is kept, without making it: nothing, or the value, which may be null.
  std::optional<Pointer> find(const Key& key) const {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end() || found->second.making) return std::nullopt;
    return found->second.value;
  }

  /// The same, and it counts as used now.
  std::optional<Pointer> use(const Key& key) {
    const std::scoped_lock lock(mutex_);
    const auto found = entries_.find(key);
    if (found == entries_.end() || found->second.making) return std::nullopt;
    uses_.splice(uses_.begin(), uses_, found->second.use);
    return found->second.value;
  }

  std::uint64_t bytes() const {
    const std::scoped_lock lock(mutex_);
    return bytes_;
  }

 private:
  static constexpr std::uint64_t kEntryBytes = 256;  ///< of an entry itself, so that nulls count too
  struct Entry {
    bool making = true;
    Pointer value;
    std::uint64_t bytes = 0;
    typename std::list<Key>::iterator use;
  };

  void keep(const Key& key, const Pointer& value, std::uint64_t bytes) {
    uses_.push_front(key);
    entries_[key] = Entry{.making = false, .value = value, .bytes = bytes, .use = uses_.begin()};
    bytes_ += bytes;
    for (auto last = uses_.end(); bytes_ > budget_ && last != uses_.begin();) {
      --last;
      const auto oldest = entries_.find(*last);
      // The one that was made just now is held by `value` at the least.
      if (oldest->second.value.use_count() > (last == uses_.begin() ? 2 : 1)) continue;
      bytes_ -= oldest->second.bytes;
      entries_.erase(oldest);
      last = uses_.erase(last);
    }
  }

  std::uint64_t budget_;
  mutable std::mutex mutex_;
  std::condition_variable made_;
  std::unordered_map<Key, Entry, Hash> entries_;
  std::list<Key> uses_;  ///< the latest is in front
  std::uint64_t bytes_ = 0;
};

}  // namespace tellurion::raster
