#include "io/fetch_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tellurion::io {
namespace {

SteadyTime later(SteadyTime time, double seconds) {
  return time + std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(seconds));
}

double secondsBetween(SteadyTime from, SteadyTime to) {
  return std::max(0.0, std::chrono::duration<double>(to - from).count());
}

double ordered(double priority) {
  return std::isnan(priority) ? -std::numeric_limits<double>::infinity() : priority;
}

}  // namespace

Fetcher::Id FetchQueue::add(const std::string& host, FetchRequest request, double priority, Fetcher::Done done) {
  std::unique_ptr<FetchHost>& place = hosts_[host];
  if (!place) place = std::make_unique<FetchHost>(host, backoff_);
  const auto job = std::make_shared<FetchJob>();
  job->id = ++lastId_;
  job->request = std::move(request);
  job->done = std::move(done);
  job->host = place.get();
  job->priority = ordered(priority);
  place->queued.insert(job);
  jobs_.emplace(job->id, job);
  return job->id;
}

FetchJobPointer FetchQueue::cancel(Fetcher::Id id) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return nullptr;
  const FetchJobPointer job = found->second;
  const bool running = job->state == FetchJob::State::running;
  forget(job);
  return running ? job : nullptr;
}

void FetchQueue::setPriority(Fetcher::Id id, double priority) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) return;
  const FetchJobPointer job = found->second;
  if (job->state != FetchJob::State::queued) {
    job->priority = ordered(priority);
    return;
  }
  auto node = job->host->queued.extract(job);
  job->priority = ordered(priority);
  job->host->queued.insert(std::move(node));
}

FetchJobPointer FetchQueue::next(SteadyTime now) {
  FetchHost* best = nullptr;
  for (const auto& [name, host] : hosts_) {
    const bool open = host->running < perHost_ || host->health.inTrouble();
    if (host->queued.empty() || !open || !host->health.maySend(now)) continue;
    if (best == nullptr || GoesEarlier()(*host->queued.begin(), *best->queued.begin())) best = host.get();
  }
  if (best == nullptr) return nullptr;
  auto which = best->queued.begin();
  // A host must not stay in trouble for the sake of one urgent URL that never comes: probes take turns.
  if (best->health.inTrouble())
    which = std::ranges::min_element(best->queued, {}, [](const FetchJobPointer& job) { return job->tries; });
  const FetchJobPointer job = best->queued.extract(which).value();
  job->state = FetchJob::State::running;
  job->probe = best->health.sent();
  ++best->running;
  return job;
}

std::vector<FetchJobPointer> FetchQueue::givenUp() {
  std::vector<FetchJobPointer> result;
  for (const auto& [name, host] : hosts_) {
    if (!host->health.inTrouble()) continue;
    std::ranges::copy_if(host->queued, std::back_inserter(result),
                         [](const FetchJobPointer& job) { return job->request.onlyIfWell; });
  }
  std::ranges::for_each(result, [this](const FetchJobPointer& job) { forget(job); });
  return result;
}

std::optional<SteadyTime> FetchQueue::wakeTime() const {
  std::optional<SteadyTime> earliest;
  const auto consider = [&](SteadyTime time) { earliest = std::min(time, earliest.value_or(time)); };
  for (const auto& [name, host] : hosts_) {
    if (!host->resting.empty()) consider((*host->resting.begin())->notBefore);
    if (!host->queued.empty() && host->health.inTrouble() && !host->health.probing())
      consider(host->health.notBefore());
  }
  return earliest;
}

void FetchQueue::succeeded(const FetchJobPointer& job) {
  FetchHost& host = *job->host;
  --host.running;
  const bool wasInTrouble = host.health.inTrouble();
  host.health.succeeded();
  if (wasInTrouble) release(host);
  forget(job);
}

bool FetchQueue::failed(const FetchJobPointer& job, const FailedRequest& how, SteadyTime now) {
  FetchHost& host = *job->host;
  --host.running;
  const double random = std::uniform_real_distribution<double>(0.0, 1.0)(random_);
  // While its host is in trouble a request learns nothing of itself: it only lets another go first.
  if (!host.health.inTrouble()) ++job->failures;
  ++job->tries;
  host.health.failed(how, job->probe, now, random);
  host.lastReason = how.reason;
  if (job->state == FetchJob::State::gone) return false;
  if (job->request.onlyIfWell) {
    forget(job);
    return true;
  }
  job->state = FetchJob::State::resting;
  job->failedByHost = how.wholeHost;
  job->notBefore =
      later(now, std::max(backoff_.delay_s(std::max(job->failures, 1), random), how.retryAfter_s.value_or(0.0)));
  host.resting.insert(job);
  return false;
}

void FetchQueue::stopped(const FetchJobPointer& job) {
  --job->host->running;
  if (job->probe) job->host->health.probeCancelled();
}

std::vector<Failure> FetchQueue::troubles(SteadyTime now) const {
  std::vector<Failure> result;
  for (const auto& [name, host] : hosts_) {
    const HostHealth& health = host->health;
    if (health.inTrouble()) {
      result.push_back({Failure::Code::ioError,
                        fmt::format("{}; in trouble for {:.0f} s, asked again in {:.0f} s", health.reason(),
                                    secondsBetween(health.since(), now), secondsBetween(now, health.notBefore())),
                        name});
    } else if (health.failing() || !host->resting.empty()) {
      std::string again;  // nothing when what failed is being asked for again
      if (!host->resting.empty())
        again =
            fmt::format("; {} request{} of it made again, the next in {:.0f} s", host->resting.size(),
                        host->resting.size() == 1 ? "" : "s", secondsBetween(now, (*host->resting.begin())->notBefore));
      result.push_back({Failure::Code::ioError, host->lastReason + again, name});
    }
  }
  return result;
}

void FetchQueue::forget(const FetchJobPointer& job) {
  job->host->queued.erase(job);
  job->host->resting.erase(job);
  job->state = FetchJob::State::gone;
  jobs_.erase(job->id);
}

// The host is well again: what failed for its sake need not wait any longer.
void FetchQueue::release(FetchHost& host) {
  for (auto at = host.resting.begin(); at != host.resting.end();) {
    const FetchJobPointer job = *at;
    if (!job->failedByHost) {
      ++at;
      continue;
    }
    at = host.resting.erase(at);
    job->state = FetchJob::State::queued;
    host.queued.insert(job);
  }
}

void FetchQueue::wake(SteadyTime now) {
  for (const auto& [name, host] : hosts_) {
    while (!host->resting.empty() && (*host->resting.begin())->notBefore <= now) {
      const FetchJobPointer job = host->resting.extract(host->resting.begin()).value();
      job->state = FetchJob::State::queued;
      host->queued.insert(job);
    }
  }
}

}  // namespace tellurion::io
