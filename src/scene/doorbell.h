#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace tellurion::scene {

/// Wakes the one who waits for something to arrive, of whatever kind. Thread-safe.
class Doorbell {
 public:
  void ring() {
    {
      const std::lock_guard lock(mutex_);
      rung_ = true;
    }
    wake_.notify_all();
  }
  /// What has arrived until now is being looked at. True: something has.
  bool quiet() {
    const std::lock_guard lock(mutex_);
    return std::exchange(rung_, false);
  }
  /// Sleeps until it rings, or has rung since it was quieted. False: the time is over.
  bool wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    return wake_.wait_for(lock, timeout, [&] { return rung_; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool rung_ = false;
};

}  // namespace tellurion::scene
