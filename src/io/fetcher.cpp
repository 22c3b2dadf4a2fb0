#include "io/fetcher.h"

#include <curl/curl.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <utility>

#include "io/fetch_queue.h"
#include "io/host_health.h"
#include "io/slow_answers.h"
#include "io/transfer.h"

namespace tellurion::io {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLongestPoll = std::chrono::milliseconds(1000);
// A transfer that got less than this in that time leaves its place to others.
constexpr std::uint64_t kSlow_bytes = 8 << 10;
constexpr auto kSlowWindow = std::chrono::seconds(2);

}  // namespace

// `mutex_` guards the queue, the statistics and what the caller's threads leave for the loop; transfers are the loop's
// own thread's.
class Fetcher::Loop {
 public:
  explicit Loop(const ResourceOptions& options)
      : options_(options),
        multi_(curl_multi_init()),
        queue_({.first_s = options.firstRetry_s, .longest_s = options.longestRetry_s},
               std::max(1, options.connectionsPerHost)) {
    inFlight_.budget = options.inFlight_bytes;
    curl_multi_setopt(multi_, CURLMOPT_MAXCONNECTS, 2L * options.connections);
    thread_ = std::thread([this] { run(); });
  }

  ~Loop() {
    {
      const std::scoped_lock lock(mutex_);
      stopping_ = true;
    }
    curl_multi_wakeup(multi_);
    thread_.join();
    curl_multi_cleanup(multi_);
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  Id start(const std::string& host, FetchRequest request, double priority, Done done) {
    const std::scoped_lock lock(mutex_);
    const Id id = queue_.add(host, std::move(request), priority, std::move(done));
    curl_multi_wakeup(multi_);
    return id;
  }

  void cancel(Id id) {
    const std::scoped_lock lock(mutex_);
    const FetchJobPointer running = queue_.cancel(id);
    if (!running) return;
    cancelled_.push_back(running);
    curl_multi_wakeup(multi_);
  }

  void setPriority(Id id, double priority) {
    const std::scoped_lock lock(mutex_);
    queue_.setPriority(id, priority);
  }

  FetcherStatistics statistics() const {
    const std::scoped_lock lock(mutex_);
    return statistics_;
  }

  std::vector<Failure> troubles() const {
    const std::scoped_lock lock(mutex_);
    std::vector<Failure> troubles = queue_.troubles(Clock::now());
    for (Failure& slow : slowAnswers(open_, Clock::now())) {
      if (std::ranges::find(troubles, slow.where, &Failure::where) == troubles.end())
        troubles.push_back(std::move(slow));
    }
    return troubles;
  }

 private:
  struct Running {
    FetchJobPointer job;
    std::unique_ptr<Transfer> transfer;
    std::uint64_t number = 0;  ///< in the order in which they began
    SteadyTime start;
    SteadyTime windowStart;
    std::uint64_t windowBytes = 0;
    bool slow = false;
  };
  using RunningMap = std::unordered_map<void*, Running>;

  void run();
  void drop(RunningMap::iterator at);
  void dropCancelled();
  void startNext();
  void resumePaused();
  void noteOpen();
  bool takeEnded();
  void finish(Running ended, int curlCode);
  void settle(const FetchJobPointer& job, TransferEnd end);
  int countOfPlaces(SteadyTime now);
  int pollTime_ms() const;

  const ResourceOptions options_;
  CURLM* const multi_;
  mutable std::mutex mutex_;
  FetchQueue queue_;
  FetcherStatistics statistics_;
  std::vector<FetchJobPointer> cancelled_;
  std::vector<OpenAnswer> open_;  ///< as they were in the loop's last turn
  bool stopping_ = false;
  BytesInFlight inFlight_;  ///< of running_
  std::uint64_t begun_ = 0;
  RunningMap running_;
  std::thread thread_;
};

void Fetcher::Loop::run() {
  while (true) {
    std::vector<FetchJobPointer> givenUp;
    {
      const std::scoped_lock lock(mutex_);
      if (stopping_) break;
      dropCancelled();
      givenUp = queue_.givenUp();
      startNext();
      resumePaused();
      noteOpen();
    }
    for (const FetchJobPointer& job : givenUp)
      job->done(Fetched{.kind = Fetched::Kind::troubled});
    int count = 0;
    curl_multi_perform(multi_, &count);
    if (takeEnded()) continue;  // there is room for the next
    curl_multi_poll(multi_, nullptr, 0, pollTime_ms(), nullptr);
  }
  while (!running_.empty())
    drop(running_.begin());
}

void Fetcher::Loop::drop(RunningMap::iterator at) {
  statistics_.receivedBytes += at->second.transfer->receivedBytes();
  curl_multi_remove_handle(multi_, at->first);
  running_.erase(at);
}

void Fetcher::Loop::dropCancelled() {
  for (const FetchJobPointer& job : std::exchange(cancelled_, {})) {
    const auto at = std::ranges::find_if(running_, [&](const auto& entry) { return entry.second.job == job; });
    if (at == running_.end()) continue;  // it ended by itself meanwhile
    drop(at);
    queue_.stopped(job);
  }
}

void Fetcher::Loop::startNext() {
  const SteadyTime now = Clock::now();
  int places = countOfPlaces(now);
  queue_.wake(now);
  while (places < options_.connections && static_cast<int>(running_.size()) < 2 * options_.connections) {
    const FetchJobPointer job = queue_.next(now);
    if (!job) return;
    const FetchRequest& request = job->request;
    auto transfer = std::make_unique<Transfer>(TransferRequest{.url = request.url,
                                                               .maxBytes = request.maxBytes,
                                                               .etag = request.etag,
                                                               .lastModified = request.lastModified,
                                                               .authorities = options_.authorities.string(),
                                                               .connectTimeout_s = options_.connectTimeout_s,
                                                               .stallTimeout_s = options_.stallTimeout_s},
                                               inFlight_);
    void* const handle = transfer->handle();
    ++places;
    ++statistics_.requests;
    curl_multi_add_handle(multi_, handle);
    running_.emplace(
        handle,
        Running{.job = job, .transfer = std::move(transfer), .number = ++begun_, .start = now, .windowStart = now});
  }
}

// The oldest that is not slow may always go on, so that there is one that ends; the others once there is room. One that
// drips would keep all servers waiting for as long as it likes.
void Fetcher::Loop::resumePaused() {
  statistics_.mostInFlight_bytes = inFlight_.most;
  const auto first = std::ranges::min_element(
      running_, {}, [](const auto& entry) { return std::pair(entry.second.slow, entry.second.number); });
  if (first == running_.end()) return;
  for (auto& [handle, running] : running_)
    running.transfer->setMayExceed(handle == first->first);
  first->second.transfer->resume();
  for (auto& [handle, running] : running_) {
    if (running.transfer->isPaused() && inFlight_.now < inFlight_.budget) running.transfer->resume();
  }
}

// For troubles(), which other threads ask for.
void Fetcher::Loop::noteOpen() {
  open_.resize(running_.size());
  auto open = open_.begin();
  for (const auto& [handle, running] : running_) {
    open->host = running.job->host->name;
    open->since = running.start;
    open->bytes = running.transfer->receivedBytes();
    ++open;
  }
}

// Transfers that count against the limit on all connections: those of servers that hardly answer do not, so that they
// cannot hold up the others.
int Fetcher::Loop::countOfPlaces(SteadyTime now) {
  int count = 0;
  for (auto& [handle, running] : running_) {
    if (running.transfer->isPaused()) {  // that nothing comes is our doing
      running.windowStart = now;
      running.windowBytes = running.transfer->receivedBytes();
    } else if (now - running.windowStart > kSlowWindow) {
      const std::uint64_t bytes = running.transfer->receivedBytes();
      running.slow = bytes - running.windowBytes < kSlow_bytes;
      running.windowStart = now;
      running.windowBytes = bytes;
    }
    count += running.slow ? 0 : 1;
  }
  return count;
}

int Fetcher::Loop::pollTime_ms() const {
  const std::scoped_lock lock(mutex_);
  const std::optional<SteadyTime> wake = queue_.wakeTime();
  if (!wake) return static_cast<int>(kLongestPoll.count());
  const auto wait = std::chrono::ceil<std::chrono::milliseconds>(*wake - Clock::now());
  return static_cast<int>(std::clamp(wait, std::chrono::milliseconds(1), kLongestPoll).count());
}

// Whether any has ended.
bool Fetcher::Loop::takeEnded() {
  bool any = false;
  int left = 0;
  while (const CURLMsg* message = curl_multi_info_read(multi_, &left)) {
    if (message->msg != CURLMSG_DONE) continue;
    const CURLcode code = message->data.result;
    auto node = running_.extract(message->easy_handle);
    curl_multi_remove_handle(multi_, node.key());
    finish(std::move(node.mapped()), code);
    any = true;
  }
  return any;
}

void Fetcher::Loop::finish(Running ended, int curlCode) {
  TransferEnd end = ended.transfer->end(curlCode);
  if (end.kind == TransferEnd::Kind::body && ended.job->request.check) {
    const Result<bool> good = ended.job->request.check(end.resource);
    if (!good) {
      end.kind = TransferEnd::Kind::badAnswer;
      end.reason = good.error().message;
    } else if (!*good) {
      end.kind = TransferEnd::Kind::nothing;
    }
  }
  {
    const std::scoped_lock lock(mutex_);
    statistics_.receivedBytes += ended.transfer->receivedBytes();
  }
  ended.transfer.reset();
  settle(ended.job, std::move(end));
}

void Fetcher::Loop::settle(const FetchJobPointer& job, TransferEnd end) {
  using Kind = TransferEnd::Kind;
  Result<Fetched> result = Fetched{.headers = std::move(end.headers)};
  {
    const std::scoped_lock lock(mutex_);
    const bool wasCancelled = job->state == FetchJob::State::gone;
    switch (end.kind) {
      case Kind::body:
        result->kind = Fetched::Kind::body;
        result->resource = std::move(end.resource);
        queue_.succeeded(job);
        break;
      case Kind::nothing:
        result->kind = Fetched::Kind::nothing;
        queue_.succeeded(job);
        break;
      case Kind::notModified:
        result->kind = Fetched::Kind::notModified;
        queue_.succeeded(job);
        break;
      case Kind::refused:
        ++statistics_.failedRequests;
        result = fail(Failure::Code::ioError, end.reason, job->request.url);
        queue_.succeeded(job);
        break;
      case Kind::badAnswer:
      case Kind::hostTrouble: {
        ++statistics_.failedRequests;
        const std::optional<double> wait_s = retryAfter_s(result->headers, wallClock());
        const FailedRequest how{.url = job->request.url,
                                .reason = std::move(end.reason),
                                .wholeHost = end.kind == Kind::hostTrouble || wait_s.has_value(),
                                .retryAfter_s = wait_s};
        if (!queue_.failed(job, how, Clock::now())) return;
        result->kind = Fetched::Kind::troubled;
        break;
      }
    }
    if (wasCancelled) return;
  }
  job->done(std::move(result));
}

Fetcher::Fetcher(const ResourceOptions& options) : loop_(std::make_unique<Loop>(options)) {}
Fetcher::~Fetcher() = default;

Fetcher::Id Fetcher::start(const std::string& host, FetchRequest request, double priority, Done done) {
  return loop_->start(host, std::move(request), priority, std::move(done));
}
void Fetcher::cancel(Id id) {
  loop_->cancel(id);
}
void Fetcher::setPriority(Id id, double priority) {
  loop_->setPriority(id, priority);
}
FetcherStatistics Fetcher::statistics() const {
  return loop_->statistics();
}
std::vector<Failure> Fetcher::troubles() const {
  return loop_->troubles();
}

}  // namespace tellurion::io
