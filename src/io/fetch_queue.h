#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "io/fetcher.h"
#include "io/host_health.h"

namespace tellurion::io {

struct FetchHost;

/// A request on its way through a FetchQueue.
struct FetchJob {
  enum class State { queued, resting, running, gone };
  Fetcher::Id id = 0;
  FetchRequest request;
  Fetcher::Done done;
  FetchHost* host = nullptr;
  State state = State::queued;
  double priority = 0.0;
  SteadyTime notBefore;       ///< of a resting one
  int failures = 0;           ///< of its own, while its host was well
  int tries = 0;              ///< that failed, whatever the reason
  bool probe = false;         ///< of a running one: it finds out whether its host is well again
  bool failedByHost = false;  ///< the last failure was its host's
};
using FetchJobPointer = std::shared_ptr<FetchJob>;

struct GoesEarlier {
  bool operator()(const FetchJobPointer& a, const FetchJobPointer& b) const {
    return a->priority != b->priority ? a->priority > b->priority : a->id < b->id;
  }
};
struct RestsShorter {
  bool operator()(const FetchJobPointer& a, const FetchJobPointer& b) const {
    return a->notBefore != b->notBefore ? a->notBefore < b->notBefore : a->id < b->id;
  }
};

/// A host, what waits for it, and how it is doing.
struct FetchHost {
  FetchHost(std::string hostName, const Backoff& backoff) : name(std::move(hostName)), health(backoff) {}
  std::string name;
  HostHealth health;
  std::set<FetchJobPointer, GoesEarlier> queued;
  std::set<FetchJobPointer, RestsShorter> resting;  ///< failed, and not to be made again yet
  int running = 0;
  std::string lastReason;  ///< of a request that rests
};

/// Which request goes out next: plain bookkeeping, no network, no threads, no clock. One thread only.
class FetchQueue {
 public:
  FetchQueue(const Backoff& backoff, int perHost) : backoff_(backoff), perHost_(perHost) {}

  Fetcher::Id add(const std::string& host, FetchRequest request, double priority, Fetcher::Done done);
  /// The job, if it was running: its transfer has to be ended, and stopped() told.
  FetchJobPointer cancel(Fetcher::Id id);
  void setPriority(Fetcher::Id id, double priority);

  /// Lets those go on that have rested long enough.
  void wake(SteadyTime now);
  /// The most urgent that may go out, now running; null: none.
  FetchJobPointer next(SteadyTime now);
  /// Those that do not wait for a host in trouble, taken out.
  std::vector<FetchJobPointer> givenUp();
  /// When there may be more to do than now, if nothing else happens.
  std::optional<SteadyTime> wakeTime() const;

  /// A running job has ended with something of use, and is forgotten.
  void succeeded(const FetchJobPointer& job);
  /// A running job has failed. It rests, or is forgotten where it is not waited for (true).
  bool failed(const FetchJobPointer& job, const FailedRequest& how, SteadyTime now);
  /// A running job that was cancelled has left the network.
  void stopped(const FetchJobPointer& job);

  std::vector<Failure> troubles(SteadyTime now) const;

 private:
  void forget(const FetchJobPointer& job);
  void release(FetchHost& host);

  Backoff backoff_;
  int perHost_;
  Fetcher::Id lastId_ = 0;
  std::map<std::string, std::unique_ptr<FetchHost>> hosts_;
  std::unordered_map<Fetcher::Id, FetchJobPointer> jobs_;
  std::mt19937 random_{std::random_device{}()};
};

}  // namespace tellurion::io
