#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/http_headers.h"
#include "io/resources.h"

namespace tellurion::io {

/// What is asked of a server.
struct FetchRequest {
  std::string url;
  std::uint64_t maxBytes = 0;
  std::function<Result<bool>(const Resource&)> check;  ///< as ResourceRequest has it
  std::string etag;                                    ///< of an older copy
  std::string lastModified;                            ///< likewise
  bool onlyIfWell = false;  ///< there is an older copy that will do: a server in trouble is not waited for
};

/// What came of it.
struct Fetched {
  enum class Kind {
    body,
    nothing,
    notModified,
    troubled,  ///< onlyIfWell, and the server is not
  };
  Kind kind = Kind::nothing;
  Resource resource;    ///< of a body
  HttpHeaders headers;  ///< but for troubled
};

struct FetcherStatistics {
  std::uint64_t requests = 0;
  std::uint64_t failedRequests = 0;
  std::uint64_t receivedBytes = 0;
  std::uint64_t mostInFlight_bytes = 0;
};

/// Requests to servers, most urgent first, on one thread with libcurl. A request that fails is made again, later and
/// later, until it succeeds, is refused or is cancelled. Thread-safe. Destruction breaks off what has not come.
class Fetcher {
 public:
  using Id = std::uint64_t;
  /// Called once, on the fetcher's thread, with no lock held.
  using Done = std::function<void(Result<Fetched>)>;

  explicit Fetcher(const ResourceOptions& options);
  ~Fetcher();
  Fetcher(const Fetcher&) = delete;
  Fetcher& operator=(const Fetcher&) = delete;

  /// `host` is hostOf(request.url). Larger priorities go first.
  Id start(const std::string& host, FetchRequest request, double priority, Done done);
  /// The connection is closed soon. `done` may be running now, or about to.
  void cancel(Id id);
  void setPriority(Id id, double priority);

  FetcherStatistics statistics() const;
  std::vector<Failure> troubles() const;

 private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace tellurion::io
