#include "io/resource_desk.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include "io/local_file.h"
#include "io/s3_address.h"
#include "io/transfer.h"
#include "io/url_secrets.h"

namespace tellurion::io {

struct ResourceWaiter {
  std::shared_ptr<ResourceJob> job;  ///< null: delivered or dropped
  double priority = 0.0;
  ResourceDesk::Ready ready;
  std::thread::id running;  ///< the thread that calls `ready` now
  bool left = false;
};

struct ResourceJob {
  std::string key;
  ResourceRequest request;
  std::vector<std::shared_ptr<ResourceWaiter>> waiters;
  double priority = 0.0;  ///< the largest of theirs
  Executor::Task lookUp;
  std::optional<Fetcher::Id> fetch;
};

namespace {

constexpr std::size_t kMostAbsent = 1 << 16;
// What a server does not have is not asked for again within this, whatever it says of keeping.
constexpr UnixSeconds kAbsentAtLeast_s = 300;

std::string keyOf(const ResourceRequest& request) {
  return request.dataset + '\n' + request.url;
}

/// The server of a bucket is what the environment says: two of them are told apart.
std::string addressOf(const std::string& url) {
  const auto address = httpAddress(url);
  return address ? address->url : url;
}

CacheKey cacheKeyOf(const ResourceRequest& request) {
  return {.dataset = keptUrl(request.dataset), .url = keptUrl(addressOf(request.url))};
}

}  // namespace

ResourceDesk::ResourceDesk(const ResourceOptions& options)
    : options_(options),
      fetcher_(std::make_unique<Fetcher>(options)),
      executor_(std::make_unique<Executor>(1, Executor::Share::background)) {
  if (!options.cacheFile.empty())
    cache_ = std::make_unique<ByteCache>(options.cacheFile, options.cacheBytes, options.warn);
}

ResourceDesk::~ResourceDesk() = default;

void ResourceDesk::close() {
  std::unordered_map<std::string, JobPointer> dropped;
  {
    const std::scoped_lock lock(mutex_);
    closed_ = true;
    dropped.swap(jobs_);
    for (const auto& [key, job] : dropped)
      for (const auto& waiter : job->waiters)
        waiter->job = nullptr;
  }
  fetcher_.reset();
  executor_.reset();
  cache_.reset();
}

std::shared_ptr<ResourceWaiter> ResourceDesk::get(const ResourceRequest& request, double priority, Ready ready) {
  auto waiter = std::make_shared<ResourceWaiter>();
  waiter->priority = priority;
  waiter->ready = std::move(ready);
  const std::scoped_lock lock(mutex_);
  if (closed_) return waiter;
  std::string key = keyOf(request);
  JobPointer& job = jobs_[key];
  waiter->job = job;
  if (job) {
    job->waiters.push_back(waiter);
    updatePriority(*job);
    return waiter;
  }
  job = std::make_shared<ResourceJob>();
  waiter->job = job;
  job->key = std::move(key);
  job->request = request;
  job->waiters.push_back(waiter);
  job->priority = options_.order == RequestOrder::mostUrgent ? priority : 0.0;
  job->lookUp = executor_->submit(job->priority, [this, job] { lookUp(job); });
  return waiter;
}

void ResourceDesk::leave(const std::shared_ptr<ResourceWaiter>& waiter) {
  Ready ready;     // what callers gave is destroyed without the lock: it may hold tickets
  JobPointer job;  // likewise
  std::unique_lock lock(mutex_);
  waiter->left = true;
  ready = std::move(waiter->ready);
  callbackEnded_.wait(
      lock, [&] { return waiter->running == std::thread::id() || waiter->running == std::this_thread::get_id(); });
  job = std::exchange(waiter->job, nullptr);
  if (!job) return;
  std::erase(job->waiters, waiter);
  if (!job->waiters.empty()) return updatePriority(*job);
  if (options_.order == RequestOrder::firstCome) return;
  jobs_.erase(job->key);
  job->lookUp.cancel();
  if (job->fetch) fetcher_->cancel(*job->fetch);
}

Executor::Task ResourceDesk::plan(double priority, std::function<void()> work) {
  const std::scoped_lock lock(mutex_);
  if (closed_) return {};
  return executor_->submit(priority, std::move(work));
}

void ResourceDesk::forget(const ResourceRequest& request) {
  if (cache_) cache_->forget(cacheKeyOf(request));
}

void ResourceDesk::setPriority(const std::shared_ptr<ResourceWaiter>& waiter, double priority) {
  const std::scoped_lock lock(mutex_);
  waiter->priority = priority;
  if (waiter->job) updatePriority(*waiter->job);
}

void ResourceDesk::updatePriority(ResourceJob& job) {
  if (options_.order == RequestOrder::firstCome) return;
  double largest = -std::numeric_limits<double>::infinity();
  for (const auto& waiter : job.waiters)
    largest = std::max(largest, waiter->priority);
  if (largest == job.priority) return;
  job.priority = largest;
  job.lookUp.setPriority(largest);
  if (job.fetch) fetcher_->setPriority(*job.fetch, largest);
}

// A job that nobody waits for any more is no longer in the table, though a thread may still work for it.
bool ResourceDesk::isCurrent(const ResourceJob& job) const {
  const auto found = jobs_.find(job.key);
  return found != jobs_.end() && found->second.get() == &job;
}

void ResourceDesk::lookUp(const JobPointer& job) {
  if (isFileUrl(job->request.url)) return deliver(job, readLocalFile(job->request));
  if (isKnownAbsent(*job)) return deliver(job, nullptr);
  const std::optional<CacheEntry> kept = cache_ ? cache_->find(cacheKeyOf(job->request)) : std::nullopt;
  const bool isGood = kept && (options_.offline || (kept->expires > wallClock() && !job->request.revalidate));
  if (!isGood) return fetch(job, kept ? &*kept : nullptr);
  {
    const std::scoped_lock lock(mutex_);
    ++fromCache_;
  }
  deliver(job, kept->resource);
}

// However old it is.
void ResourceDesk::giveKept(const JobPointer& job) {
  const std::optional<CacheEntry> kept = cache_->find(cacheKeyOf(job->request));
  if (!kept) return fetch(job, nullptr);  // pushed out meanwhile
  {
    const std::scoped_lock lock(mutex_);
    ++fromCache_;
  }
  deliver(job, kept->resource);
}

void ResourceDesk::fetch(const JobPointer& job, const CacheEntry* older) {
  const ResourceRequest& request = job->request;
  if (options_.offline)
    return deliver(
        job, fail(Failure::Code::notFound, "not kept on this machine, and the network is not to be used", request.url));
  const Result<std::string> host = hostOf(request.url);
  if (!host) return deliver(job, tl::unexpected(host.error()));
  FetchRequest wanted{.url = request.url, .maxBytes = request.maxBytes, .check = request.check};
  if (older != nullptr) {
    wanted.etag = older->etag;
    wanted.lastModified = older->lastModified;
    wanted.onlyIfWell = true;
  }
  const std::scoped_lock lock(mutex_);
  if (!isCurrent(*job)) return;
  job->fetch = fetcher_->start(*host, std::move(wanted), job->priority,
                               [this, job](Result<Fetched> answer) { fetched(job, std::move(answer)); });
}

void ResourceDesk::fetched(const JobPointer& job, Result<Fetched> answer) {
  if (!answer) return deliver(job, tl::unexpected(answer.error()));
  switch (answer->kind) {
    case Fetched::Kind::body: {
      const auto resource = std::make_shared<const Resource>(std::move(answer->resource));
      remember(*job, resource, answer->headers);
      return deliver(job, resource);
    }
    case Fetched::Kind::nothing:
      remember(*job, nullptr, answer->headers);
      return deliver(job, nullptr);
    case Fetched::Kind::notModified: {
      const UnixSeconds now = wallClock();
      cache_->renew(cacheKeyOf(job->request), now, freshnessOf(answer->headers, now).expires);
      break;
    }
    case Fetched::Kind::troubled:
      break;
  }
  const std::scoped_lock lock(mutex_);
  if (!isCurrent(*job)) return;
  job->fetch.reset();
  job->lookUp = executor_->submit(job->priority, [this, job] { giveKept(job); });
}

void ResourceDesk::remember(const ResourceJob& job, Bytes resource, const HttpHeaders& headers) {
  const UnixSeconds now = wallClock();
  const Freshness freshness = freshnessOf(headers, now);
  const UnixSeconds expires = resource ? freshness.expires : std::max(freshness.expires, now + kAbsentAtLeast_s);
  if (!resource) {
    const std::scoped_lock lock(mutex_);
    if (absent_.size() >= kMostAbsent) absent_.clear();
    absent_[std::hash<std::string>()(job.key)] = expires;
  }
  if (!cache_ || !freshness.store) return;
  cache_->keep(cacheKeyOf(job.request), {.resource = std::move(resource),
                                         .etag = headers.etag,
                                         .lastModified = headers.lastModified,
                                         .fetched = now,
                                         .expires = expires});
}

bool ResourceDesk::isKnownAbsent(const ResourceJob& job) const {
  const std::scoped_lock lock(mutex_);
  const auto found = absent_.find(std::hash<std::string>()(job.key));
  return found != absent_.end() && found->second > wallClock();
}

void ResourceDesk::deliver(const JobPointer& job, const Result<Bytes>& result) {
  std::unique_lock lock(mutex_);
  if (!isCurrent(*job)) return;
  jobs_.erase(job->key);
  const auto waiters = std::exchange(job->waiters, {});
  for (const auto& waiter : waiters)
    waiter->job = nullptr;
  for (const auto& waiter : waiters) {
    if (waiter->left || closed_) continue;
    waiter->running = std::this_thread::get_id();
    Ready ready = std::exchange(waiter->ready, nullptr);
    lock.unlock();
    ready(result);
    ready = nullptr;
    lock.lock();
    waiter->running = {};
    callbackEnded_.notify_all();
  }
}

ResourceStatistics ResourceDesk::statistics() const {
  const std::scoped_lock lock(mutex_);
  ResourceStatistics result;
  result.waiting = jobs_.size();
  if (closed_) return result;
  const FetcherStatistics network = fetcher_->statistics();
  result.requests = network.requests;
  result.failedRequests = network.failedRequests;
  result.receivedBytes = network.receivedBytes;
  result.mostInFlight_bytes = network.mostInFlight_bytes;
  result.fromCache = fromCache_;
  result.cacheBytes = cache_ ? cache_->bytes() : 0;
  return result;
}

std::vector<Failure> ResourceDesk::troubles() const {
  const std::scoped_lock lock(mutex_);
  return closed_ ? std::vector<Failure>{} : fetcher_->troubles();
}

Failure ResourceDesk::timedOut(const ResourceRequest& request, double timeout_s) const {
  std::string message = fmt::format("did not come within {:g} s", timeout_s);
  const Result<std::string> host = hostOf(request.url);
  for (const Failure& trouble : troubles())
    if (host && trouble.where == *host) message += " (" + trouble.message + ")";
  return {Failure::Code::ioError, std::move(message), request.url};
}

}  // namespace tellurion::io
