#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "io/byte_cache.h"
#include "io/executor.h"
#include "io/fetcher.h"
#include "io/resources.h"

namespace tellurion::io {

struct ResourceJob;

/// Who asked for a resource. All of it is guarded by its desk.
struct ResourceWaiter;

/// Where requests for resources come in and answers go out: equal requests become one job, which goes to what is kept,
/// then to the network, and its answer to all who wait for it. Thread-safe.
class ResourceDesk {
 public:
  using Bytes = std::shared_ptr<const Resource>;
  using Ready = Resources::Ready;

  explicit ResourceDesk(const ResourceOptions& options);
  ~ResourceDesk();
  ResourceDesk(const ResourceDesk&) = delete;
  ResourceDesk& operator=(const ResourceDesk&) = delete;
  /// Ends all threads; what waits is dropped. What is asked for later never comes.
  void close();

  std::shared_ptr<ResourceWaiter> get(const ResourceRequest& request, double priority, Ready ready);
  /// After it no callback of the waiter begins, and none runs but on this thread.
  void leave(const std::shared_ptr<ResourceWaiter>& waiter);
  Executor::Task plan(double priority, std::function<void()> work);
  void forget(const ResourceRequest& request);
  void setPriority(const std::shared_ptr<ResourceWaiter>& waiter, double priority);

  ResourceStatistics statistics() const;
  std::vector<Failure> troubles() const;
  /// Why a request did not come in time.
  Failure timedOut(const ResourceRequest& request, double timeout_s) const;

 private:
  using JobPointer = std::shared_ptr<ResourceJob>;

  void lookUp(const JobPointer& job);
  void giveKept(const JobPointer& job);
  void fetch(const JobPointer& job, const CacheEntry* older);
  void fetched(const JobPointer& job, Result<Fetched> answer);
  void deliver(const JobPointer& job, const Result<Bytes>& result);
  void remember(const ResourceJob& job, Bytes resource, const HttpHeaders& headers);
  bool isKnownAbsent(const ResourceJob& job) const;
  bool isCurrent(const ResourceJob& job) const;
  void updatePriority(ResourceJob& job);

  const ResourceOptions options_;
  mutable std::mutex mutex_;  // never held while a callback runs or the disk is asked
  std::condition_variable callbackEnded_;
  std::unordered_map<std::string, JobPointer> jobs_;  // by data set and URL
  // What servers do not have, by a hash of data set and URL, and until when: also where no disk cache is.
  std::unordered_map<std::size_t, UnixSeconds> absent_;
  std::uint64_t fromCache_ = 0;
  bool closed_ = false;
  std::unique_ptr<ByteCache> cache_;  // null: nothing is kept on disk
  std::unique_ptr<Fetcher> fetcher_;
  std::unique_ptr<Executor> executor_;
};

}  // namespace tellurion::io
