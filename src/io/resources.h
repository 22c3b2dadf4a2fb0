#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/executor.h"
#include "io/failure.h"

namespace tellurion::io {

/// What a server gave for a URL.
struct Resource {
  std::vector<std::byte> bytes;
  std::string contentType;  ///< as the server stated it, lower case, without parameters; may be empty
};

/// What is wanted of the network or of what is kept of it.
struct ResourceRequest {
  std::string url;      ///< http, https, or file: a file of this machine, which is read and not kept
  std::string dataset;  ///< what it is a part of, for the cache and for messages: server, layer, style, time, ...
  std::uint64_t maxBytes = std::uint64_t{32} << 20;
  /// Whether the bytes are what was asked for, called on a thread of the network, so it must be quick: true, or false
  /// when they say that there is nothing at this place. A failure (an error page, a damaged image) is asked for again,
  /// later and later, and is never kept. Empty: anything is good.
  std::function<Result<bool>(const Resource&)> check;
  bool revalidate = false;  ///< the server is asked whether what is kept is still good, however long it said that it is
};

/// In which requests to servers are made.
enum class RequestOrder : std::uint8_t {
  mostUrgent,  ///< and what nobody waits for any more is cancelled
  firstCome,   ///< priorities do not count, and all that was asked for comes: what the other order is measured against
};

struct ResourceOptions {
  std::filesystem::path cacheFile;                    ///< empty: nothing is kept on disk
  std::uint64_t cacheBytes = std::uint64_t{2} << 30;  ///< of cacheFile, least recently used goes first
  bool offline = false;                               ///< nothing but what is kept, however old
  /// Told of what is wrong with cacheFile, so that nothing is kept or what was kept is lost: once each, on any thread.
  std::function<void(const Failure&)> warn;
  RequestOrder order = RequestOrder::mostUrgent;
  int connectionsPerHost = 6;
  int connections = 24;  ///< to all hosts; up to twice as many while servers that hardly answer hold theirs
  /// Of answers that are not whole yet, all together: above it all transfers but the oldest wait, so that many large
  /// answers at a time take no more than this and one answer's own bound.
  std::uint64_t inFlight_bytes = std::uint64_t{256} << 20;
  std::filesystem::path authorities;  ///< certificates (PEM) of whom https trusts; empty: those of the system
  double connectTimeout_s = 10.0;
  double stallTimeout_s = 30.0;  ///< whole seconds: less than 256 bytes a second for so long is no answer
  double firstRetry_s = 1.0;     ///< doubled with each failure ...
  double longestRetry_s = 60.0;  ///< ... up to this
};

struct ResourceStatistics {
  std::uint64_t requests = 0;        ///< sent to a server
  std::uint64_t failedRequests = 0;  ///< of those: no answer, or one that was no good
  std::uint64_t receivedBytes = 0;
  std::uint64_t mostInFlight_bytes = 0;  ///< of answers that were not whole yet, all together
  std::uint64_t fromCache = 0;
  std::uint64_t cacheBytes = 0;
  std::uint64_t waiting = 0;  ///< asked for and not here yet
};

/// Bytes by URL: from the disk cache, else from the server (libcurl, a thread of its own). Equal requests are one.
/// Thread-safe.
class Resources {
 public:
  explicit Resources(const ResourceOptions& options);
  ~Resources();  ///< drops what has not come; no callback runs after
  Resources(const Resources&) = delete;
  Resources& operator=(const Resources&) = delete;

  /// A request under way. Destroying it cancels: no callback begins afterwards, one that runs is waited for (but not on
  /// its own thread). The transfer itself ends when nobody else waits for it.
  class Ticket {
   public:
    Ticket();
    Ticket(Ticket&&) noexcept;
    Ticket& operator=(Ticket&&) noexcept;
    ~Ticket();
    void setPriority(double priority) const;

   private:
    friend class Resources;
    struct State;
    std::shared_ptr<State> state_;
  };

  /// `ready` is called once, on a thread of this object, never from within get(): with the bytes; with null where the
  /// server says that there is nothing (remembered until that expires); with a failure when they cannot come (offline
  /// and not kept, a URL that cannot be asked for, a refusal like 401 or 403). While a server is failing (no answer,
  /// 5xx, 429, bad bytes) it is not called: the request is made again with backoff until the server is well, unless
  /// something older is kept: that is given. It must be quick.
  using Ready = std::function<void(Result<std::shared_ptr<const Resource>>)>;
  [[nodiscard]] Ticket get(const ResourceRequest& request, double priority, Ready ready);

  /// What leads to requests and takes a tenth of a millisecond or more, on the thread that looks things up, in the
  /// order of priorities among what waits there: for who must not spend that time. `work` must not wait for anything.
  /// Dropped where the resources end before it begins.
  Executor::Task plan(double priority, std::function<void()> work);

  /// What came for a request is of no use after all, as the caller found out later than `check` could: it is kept no
  /// longer, and who asks again has it from the server.
  void forget(const ResourceRequest& request);

  /// As get(), waited for. timeout_s over: a failure that says what the server's trouble is.
  Result<std::shared_ptr<const Resource>> wait(const ResourceRequest& request, double timeout_s);
  /// Ends all wait(), now and later, with Failure::Code::cancelled: who leaves does not wait for those who wait.
  void cancelWaits();

  ResourceStatistics statistics() const;
  /// What is wrong now, one for each host in trouble: which, why, since when, when it is asked again; or that its
  /// answers hardly come.
  std::vector<Failure> troubles() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tellurion::io
