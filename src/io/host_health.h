#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <string>

namespace tellurion::io {

using SteadyTime = std::chrono::steady_clock::time_point;

/// How long to wait before asking again: first_s, doubled with each failure up to longest_s.
struct Backoff {
  double first_s = 1.0;
  double longest_s = 60.0;

  /// After so many failures in a row (>= 1), up to a fifth more or less: random in [0, 1) spreads requests that failed
  /// together.
  double delay_s(int failures, double random) const;
};

/// A request that a server did not serve.
struct FailedRequest {
  std::string url;
  std::string reason;                  ///< half a sentence
  bool wholeHost = false;              ///< no connection, 429: what says something of every request to that host
  std::optional<double> retryAfter_s;  ///< as the server wishes
};

/// How a host is doing, and when it may be asked. In trouble is a host that said so or could not be reached, or where
/// several different URLs failed in a row; then one request at a time finds out whether it is well again. A value; one
/// thread only.
class HostHealth {
 public:
  explicit HostHealth(const Backoff& backoff) : backoff_(backoff) {}

  bool inTrouble() const { return rounds_ > 0; }
  /// Something failed, and nothing has succeeded since.
  bool failing() const { return !failed_.empty(); }
  /// Whether a request may go out: any number while the host is well, else one when its time has come.
  bool maySend(SteadyTime now) const { return !inTrouble() || (!probing_ && now >= notBefore_); }
  bool probing() const { return probing_; }
  /// Tells that a request goes out; true: it is the one that finds out, and how it ends must be told as such.
  bool sent();

  /// An answer that is of use, if only that there is nothing, or that the request is refused.
  void succeeded();
  void failed(const FailedRequest& request, bool wasProbe, SteadyTime now, double random);
  /// The probe was cancelled.
  void probeCancelled() { probing_ = false; }

  SteadyTime notBefore() const { return notBefore_; }  ///< of a host in trouble
  SteadyTime since() const { return since_; }          ///< of a failing host
  const std::string& reason() const { return reason_; }

 private:
  Backoff backoff_;
  std::set<std::string> failed_;  // different URLs, since the last success
  int rounds_ = 0;                // of asking in vain; 0: not in trouble
  bool probing_ = false;
  SteadyTime notBefore_;
  SteadyTime since_;
  std::string reason_;
};

}  // namespace tellurion::io
