#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

namespace tellurion::io {

/// Worker threads with one priority queue. Thread-safe. Destruction drops what has not begun and waits for what has.
class Executor {
 public:
  enum class Share : std::uint8_t {
    equal,  ///< of the cores, as any thread of the program
    /// Threads that somebody waits for at a screen go first where cores are short. As `equal` on systems that do not
    /// tell threads of a program apart.
    background,
  };
  /// threads >= 1; 0 means one for each core but one, at least one.
  explicit Executor(int threads = 0, Share share = Share::equal);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// A handle to a task that has been handed in. Copies share it. Thread-safe; may outlive the executor. A handle that
  /// was made empty, or whose task has begun, ended, or been cancelled or dropped, takes every call and does nothing.
  class Task {
   public:
    void cancel() const;               ///< a task that has not begun never will; its closure is destroyed here and now
    void setPriority(double p) const;  ///< larger runs first; takes effect while the task waits

   private:
    friend class Executor;
    struct State;
    std::shared_ptr<State> state_;
  };

  /// Larger priorities begin first, equal ones in the order of their coming; NaN counts as the lowest. `work` must not
  /// throw; it may submit, cancel and re-order other tasks. Its closure is destroyed on the worker, right after it ran.
  Task submit(double priority, std::function<void()> work);
  int threadCount() const { return static_cast<int>(threads_.size()); }
  /// Tasks that have not begun.
  std::size_t waiting() const;

 private:
  struct Queue;
  std::shared_ptr<Queue> queue_;
  std::vector<std::thread> threads_;
};

}  // namespace tellurion::io
