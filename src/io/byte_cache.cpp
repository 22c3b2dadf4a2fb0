#include "io/byte_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

namespace tellurion::io {
namespace {

namespace fs = std::filesystem;

// Writes are gathered for so long, or until they are so many bytes.
constexpr auto kGather = std::chrono::milliseconds(200);
constexpr std::uint64_t kGathered_bytes = 4 << 20;
constexpr std::uint64_t kLargestBatch_bytes = 8 << 20;
constexpr std::uint64_t kLargestEntry_bytes = 32 << 20;
// A disk that is slower than the network must not fill the memory.
constexpr std::uint64_t kMostPending_bytes = 64 << 20;
constexpr auto kUsesEvery = std::chrono::seconds(30);
constexpr std::size_t kMostUses = 1024;
// After a failure (a full disk, another program that holds the file).
constexpr auto kPause = std::chrono::seconds(30);
// What a row costs beside its body, about; bodies fill whole pages.
constexpr std::uint64_t kRow_bytes = 1024;
constexpr std::uint64_t kPage_bytes = 4096;
// The log beside the file is part of the budget: it has to hold the largest entry.
constexpr std::uint64_t kMostLog_bytes = 48 << 20;

std::int64_t wallClock_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

fs::path beside(const fs::path& path, const char* ending) {
  return path.string() + ending;
}

}  // namespace

std::uint64_t ByteCache::Change::size() const {
  const std::uint64_t body = entry && entry->resource ? entry->resource->bytes.size() : 0;
  return kRow_bytes + (body + kPage_bytes - 1) / kPage_bytes * kPage_bytes;
}

std::uint64_t ByteCache::limit() const {
  return budget_ - std::min(kMostLog_bytes, budget_ / 4);
}

ByteCache::ByteCache(fs::path path, std::uint64_t budget, Warn warn)
    : path_(std::move(path)), budget_(budget), warn_(std::move(warn)) {
  open();
  thread_ = std::thread([this] { run(); });
}

ByteCache::~ByteCache() {
  {
    const std::scoped_lock lock(queueMutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
  reader_.reset();  // the last to close writes the log into the file: the one that can
}

void ByteCache::tell(Failure failure) {
  if (std::exchange(told_, true) || !warn_) return;
  warn_(failure);
}

void ByteCache::open() {
  const Result<void> opened = openFile();
  if (opened) return;
  if (opened.error().code == Failure::Code::corrupt) return replaceDamaged(opened.error());
  // What is kept may still be read where nothing may be written.
  Result<CacheFile> readable = CacheFile::open(path_, SqliteConnection::Mode::read);
  if (readable) {
    const std::scoped_lock lock(readMutex_);
    reader_ = std::move(*readable);
  }
  Failure failure = opened.error();
  failure.message += "; what comes from servers is not kept on this disk";
  tell(std::move(failure));
}

Result<void> ByteCache::openFile() {
  const std::int64_t logBytes = std::min(CacheFile::kLog_bytes, static_cast<std::int64_t>(budget_ / 16));
  Result<CacheFile> writer = CacheFile::open(path_, SqliteConnection::Mode::create, logBytes);
  if (!writer) return tl::unexpected(writer.error());
  Result<CacheFile> reader = CacheFile::open(path_, SqliteConnection::Mode::read);
  if (!reader) return tl::unexpected(reader.error());
  const Result<std::uint64_t> bytes = writer->bytes();
  if (!bytes) return tl::unexpected(bytes.error());
  const std::scoped_lock lock(readMutex_, queueMutex_);
  writer_ = std::move(*writer);
  reader_ = std::move(*reader);
  bytes_ = *bytes;
  return {};
}

void ByteCache::replaceDamaged(const Failure& why) {
  {
    const std::scoped_lock lock(readMutex_);
    reader_.reset();
  }
  writer_.reset();
  {
    // Another process may have begun a new file already.
    const Result<CacheFile> now = CacheFile::open(path_, SqliteConnection::Mode::write);
    const Result<bool> sound = now ? now->isSound() : Result<bool>(false);
    if (sound && *sound && openFile()) return;
  }
  const fs::path aside = beside(path_, ".damaged");
  std::error_code error;
  fs::rename(path_, aside, error);
  const std::error_code moved = error;
  fs::rename(beside(path_, "-wal"), beside(aside, "-wal"), error);
  fs::remove(beside(path_, "-shm"), error);
  const Result<void> opened = moved ? Result<void>(tl::unexpected(why)) : openFile();
  Failure failure{Failure::Code::corrupt, why.message, path_.string()};
  failure.message += opened ? fmt::format("; it was moved to {}, and a new one begun", aside.string())
                            : "; what comes from servers is not kept on this disk";
  if (warn_) warn_(failure);
}

std::optional<CacheEntry> ByteCache::find(const CacheKey& key) {
  {
    const std::scoped_lock lock(queueMutex_);
    for (const Changes* const changes : {&pending_, &writing_}) {
      const auto found = changes->find(key);
      if (found == changes->end()) continue;
      if (found->second.isForgotten) return std::nullopt;
      if (found->second.entry) return found->second.entry;
    }
  }
  const std::scoped_lock reading(readMutex_);
  if (!reader_) return std::nullopt;
  Result<std::optional<CacheFile::Found>> found = reader_->find(key);
  const std::scoped_lock lock(queueMutex_);
  if (!found && found.error().code == Failure::Code::corrupt) {
    damage_ = found.error();
    wake_.notify_all();
  }
  if (!found || !*found) return std::nullopt;
  for (const Changes* const changes : {&writing_, &pending_}) {
    const auto renewed = changes->find(key);
    if (renewed == changes->end()) continue;
    (*found)->entry.fetched = renewed->second.fetched;
    (*found)->entry.expires = renewed->second.expires;
  }
  uses_[(*found)->row] = wallClock_ms();
  if (uses_.size() >= kMostUses) wake_.notify_all();
  return std::move((*found)->entry);
}

void ByteCache::keep(const CacheKey& key, CacheEntry entry) {
  const std::scoped_lock lock(queueMutex_);
  Change change{.entry = std::move(entry)};
  // One that would push out most of the others is not worth it.
  if (change.size() > std::min(kLargestEntry_bytes, budget_ / 8) || pendingBytes_ + change.size() > kMostPending_bytes)
    return;
  Change& slot = pending_[key];
  pendingBytes_ += change.size();
  pendingBytes_ -= std::min(pendingBytes_, slot.entry ? slot.size() : 0);
  slot = std::move(change);
  wake_.notify_all();
}

void ByteCache::renew(const CacheKey& key, UnixSeconds fetched, UnixSeconds expires) {
  const std::scoped_lock lock(queueMutex_);
  const auto [slot, isNew] = pending_.try_emplace(key);
  Change& change = slot->second;
  if (isNew) pendingBytes_ += change.size();
  change.fetched = fetched;
  change.expires = expires;
  if (change.entry) {
    change.entry->fetched = fetched;
    change.entry->expires = expires;
  }
  wake_.notify_all();
}

void ByteCache::forget(const CacheKey& key) {
  const std::scoped_lock lock(queueMutex_);
  Change& slot = pending_[key];
  pendingBytes_ -= std::min(pendingBytes_, slot.entry ? slot.size() : 0);
  slot = {.entry = std::nullopt, .isForgotten = true};
  pendingBytes_ += slot.size();
  wake_.notify_all();
}

std::uint64_t ByteCache::bytes() const {
  const std::scoped_lock lock(queueMutex_);
  return bytes_;
}

// Of a file that was made with a larger budget.
void ByteCache::trim() {
  std::error_code error;
  const std::uintmax_t fileBytes = fs::file_size(path_, error);
  if (!writer_ || error || fileBytes <= budget_) return;
  write({}, {});
  if (const auto done = writer_->releaseFreePages(); !done) tell(done.error());
}

void ByteCache::run() {
  trim();
  std::unique_lock lock(queueMutex_);
  while (true) {
    wake_.wait_for(lock, kUsesEvery,
                   [&] { return stopping_ || damage_ || !pending_.empty() || uses_.size() >= kMostUses; });
    if (!stopping_ && !pending_.empty())
      wake_.wait_for(lock, kGather, [&] { return stopping_ || pendingBytes_ >= kGathered_bytes; });
    const std::optional<Failure> damage = std::exchange(damage_, std::nullopt);
    const std::uint64_t most = std::min(kLargestBatch_bytes, budget_ / 16);
    std::uint64_t taken = 0;
    while (!pending_.empty() && (taken == 0 || taken + pending_.begin()->second.size() <= most)) {
      auto node = pending_.extract(pending_.begin());
      taken += node.mapped().size();
      writing_.insert(std::move(node));
    }
    pendingBytes_ -= std::min(pendingBytes_, taken);
    const Uses uses = std::exchange(uses_, {});
    const bool last = stopping_ && pending_.empty();
    lock.unlock();
    if (damage) replaceDamaged(*damage);
    if (!writing_.empty() || !uses.empty()) write(writing_, uses);
    lock.lock();
    writing_.clear();
    if (last) return;
  }
}

void ByteCache::write(const Changes& changes, const Uses& uses) {
  if (!writer_ || std::chrono::steady_clock::now() < writeAgain_) return;
  Result<void> written = tryWrite(changes, uses);
  if (!written && written.error().code == Failure::Code::corrupt) {
    replaceDamaged(written.error());
    if (!writer_) return;
    written = tryWrite(changes, {});
  }
  if (written) return;
  writeAgain_ = std::chrono::steady_clock::now() + kPause;
  Failure failure = written.error();
  failure.message = "what comes from servers is not kept on disk for now: " + failure.message;
  tell(std::move(failure));
}

Result<void> ByteCache::tryWrite(const Changes& changes, const Uses& uses) {
  std::uint64_t size = 0;
  for (const auto& [key, change] : changes)
    size += change.size();
  Result<void> done = writer_->begin();
  if (!done) return done;
  const std::int64_t now_ms = wallClock_ms();
  for (const auto& [row, used_ms] : uses)
    if (done) done = writer_->markUsed(row, used_ms);
  if (done) done = writer_->shrinkTo(limit() - std::min(limit(), size));
  for (const auto& [key, change] : changes) {
    if (!done) break;
    if (change.isForgotten) {
      done = writer_->erase(key);
    } else {
      done = change.entry ? writer_->write(key, *change.entry, now_ms)
                          : writer_->renew(key, change.fetched, change.expires);
    }
  }
  const Result<std::uint64_t> bytes = writer_->bytes();
  if (done) done = writer_->commit();
  if (!done) {
    writer_->rollback();
    return done;
  }
  const std::scoped_lock lock(queueMutex_);
  if (bytes) bytes_ = *bytes;
  return {};
}

}  // namespace tellurion::io
