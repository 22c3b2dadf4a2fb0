#include "io/host_health.h"

#include <algorithm>
#include <cmath>

namespace tellurion::io {
namespace {

constexpr std::size_t kFailedUrlsOfTrouble = 3;
constexpr double kSpread = 0.2;
constexpr int kMostDoublings = 30;

SteadyTime later(SteadyTime time, double seconds) {
  return time + std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

double Backoff::delay_s(int failures, double random) const {
  const double delay = std::min(longest_s, std::ldexp(first_s, std::clamp(failures - 1, 0, kMostDoublings)));
  return delay * (1.0 + kSpread * (2.0 * random - 1.0));
}

bool HostHealth::sent() {
  if (!inTrouble()) return false;
  probing_ = true;
  return true;
}

void HostHealth::succeeded() {
  *this = HostHealth(backoff_);
}

void HostHealth::failed(const FailedRequest& request, bool wasProbe, SteadyTime now, double random) {
  if (!failing()) since_ = now;
  // A host that is in trouble for days must not fill the memory with its URLs.
  if (failed_.size() < kFailedUrlsOfTrouble) failed_.insert(request.url);
  reason_ = request.reason;
  if (wasProbe) probing_ = false;
  // Requests that were on their way when trouble began say nothing new.
  const bool begins = !inTrouble() && (request.wholeHost || failed_.size() >= kFailedUrlsOfTrouble);
  if (begins || (wasProbe && inTrouble())) {
    ++rounds_;
    notBefore_ = later(now, backoff_.delay_s(rounds_, random));
  }
  if (inTrouble() && request.retryAfter_s) notBefore_ = std::max(notBefore_, later(now, *request.retryAfter_s));
}

}  // namespace tellurion::io
