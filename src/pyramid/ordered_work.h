#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "io/executor.h"

namespace tellurion::pyramid {

/// Work done by many threads whose results come out in the order of its coming; no more than `window` pieces wait at a
/// time, which bounds memory. One thread pushes and pops. Destruction drops what has not begun.
template <class Result>
class OrderedWork {
 public:
  OrderedWork(int threads, std::size_t window) : window_(window), executor_(threads) {}

  bool isFull() const { return slots_.size() >= window_; }
  bool isEmpty() const { return slots_.empty(); }

  /// `work` runs on a worker thread and must not throw.
  void push(std::function<Result()> work) {
    auto slot = std::make_shared<Slot>();
    slots_.push_back(slot);
    executor_.submit(0.0, [slot, shared = shared_, work = std::move(work)] {
      Result result = work();
      {
        const std::scoped_lock lock(shared->mutex);
        slot->result = std::move(result);
      }
      shared->arrived.notify_one();
    });
  }

  /// Waits for the oldest piece of work. There must be one.
  Result pop() {
    const std::shared_ptr<Slot> slot = std::move(slots_.front());
    slots_.pop_front();
    std::unique_lock lock(shared_->mutex);
    shared_->arrived.wait(lock, [&] { return slot->result.has_value(); });
    return std::move(*slot->result);
  }

 private:
  struct Slot {
    std::optional<Result> result;
  };
  struct Shared {
    std::mutex mutex;
    std::condition_variable arrived;
  };
  std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
  std::deque<std::shared_ptr<Slot>> slots_;
  std::size_t window_;
  io::Executor executor_;  // last: its threads end before the rest goes
};

}  // namespace tellurion::pyramid
