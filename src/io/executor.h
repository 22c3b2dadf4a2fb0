#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

namespace tellurion::io {

/// Worker threads with one priority queue. Thread-safe. Destruction drops what has not begun and waits for what has.
class Executor {
 public:
  /// threads >= 1; 0 means one for each core but one, at least one.
  explicit Executor(int threads = 0);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// A handle to a task that has been handed in. Copies share it.
  class Task {
   public:
    void cancel() const;             ///< a task that has not begun never will
    void setPriority(double p) const;  ///< larger runs first; takes effect while the task waits
   private:
    friend class Executor;
    struct State;
    std::shared_ptr<State> state_;
  };

  Task submit(double priority, std::function<void()> work);
  int threadCount() const { return static_cast<int>(threads_.size()); }
  std::size_t waiting() const;

 private:
  void run();
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::shared_ptr<Task::State>> queue_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace tellurion::io
