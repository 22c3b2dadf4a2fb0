#include "io/executor.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <mutex>
#include <set>
#include <utility>

#include "io/thread_share.h"

namespace tellurion::io {

// All but `queue` is guarded by the queue's mutex. `work` is empty once the task has left the queue.
struct Executor::Task::State {
  std::shared_ptr<Queue> queue;
  std::function<void()> work;
  double priority = 0.0;
  std::uint64_t arrival = 0;
};

// Shared by the executor, its threads and every task, so that a handle may outlive the executor.
struct Executor::Queue {
  struct RunsEarlier {
    bool operator()(const std::shared_ptr<Task::State>& a, const std::shared_ptr<Task::State>& b) const {
      return a->priority != b->priority ? a->priority > b->priority : a->arrival < b->arrival;
    }
  };
  using Waiting = std::set<std::shared_ptr<Task::State>, RunsEarlier>;

  mutable std::mutex mutex;
  std::condition_variable wake;
  Waiting waiting;
  std::uint64_t arrivals = 0;
  bool stopping = false;

  void run();
  std::function<void()> next();
};

namespace {

double ordered(double priority) {
  return std::isnan(priority) ? -std::numeric_limits<double>::infinity() : priority;
}

int threadsFor(int wanted) {
  if (wanted > 0) return wanted;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) - 1);
}

}  // namespace

// Waits for the most urgent task; an empty function when the executor stops.
std::function<void()> Executor::Queue::next() {
  std::unique_lock lock(mutex);
  wake.wait(lock, [this] { return stopping || !waiting.empty(); });
  if (stopping) return {};
  const std::shared_ptr<Task::State> task = *waiting.begin();
  waiting.erase(waiting.begin());
  return std::exchange(task->work, {});
}

void Executor::Queue::run() {
  while (const std::function<void()> work = next())
    work();
}

Executor::Executor(int threads, Share share) : queue_(std::make_shared<Queue>()) {
  const int count = threadsFor(threads);
  threads_.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    threads_.emplace_back([queue = queue_, share] {
      if (share == Share::background) stepBack();
      queue->run();
    });
}

Executor::~Executor() {
  Queue::Waiting dropped;
  std::vector<std::function<void()>>
      closures;  // destroyed without the lock: a closure may hold the last handle to anything
  {
    const std::scoped_lock lock(queue_->mutex);
    queue_->stopping = true;
    dropped.swap(queue_->waiting);
    for (const auto& task : dropped)
      closures.push_back(std::exchange(task->work, {}));
  }
  queue_->wake.notify_all();
  for (std::thread& thread : threads_)
    thread.join();
}

Executor::Task Executor::submit(double priority, std::function<void()> work) {
  Task task;
  if (!work) return task;
  task.state_ = std::make_shared<Task::State>();
  task.state_->queue = queue_;
  task.state_->work = std::move(work);
  task.state_->priority = ordered(priority);
  {
    const std::scoped_lock lock(queue_->mutex);
    if (queue_->stopping) return {};  // a running task handed it in during destruction; the closure goes with `task`
    task.state_->arrival = queue_->arrivals++;
    queue_->waiting.insert(task.state_);
  }
  queue_->wake.notify_one();
  return task;
}

std::size_t Executor::waiting() const {
  const std::scoped_lock lock(queue_->mutex);
  return queue_->waiting.size();
}

void Executor::Task::cancel() const {
  if (!state_) return;
  std::function<void()> work;  // destroyed after the lock is released
  const std::scoped_lock lock(state_->queue->mutex);
  if (!state_->work) return;
  state_->queue->waiting.erase(state_);
  work = std::exchange(state_->work, {});
}

void Executor::Task::setPriority(double p) const {
  if (!state_) return;
  const std::scoped_lock lock(state_->queue->mutex);
  if (!state_->work) return;
  auto node = state_->queue->waiting.extract(state_);
  state_->priority = ordered(p);
  state_->queue->waiting.insert(std::move(node));
}

}  // namespace tellurion::io
