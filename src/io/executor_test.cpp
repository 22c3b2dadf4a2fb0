#include "io/executor.h"

#include <gtest/gtest.h>

#ifdef __linux__
#include <sched.h>
#include <sys/resource.h>
#endif

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <mutex>
#include <semaphore>
#include <string>

namespace tellurion::io {
namespace {

// Holds the only worker of an executor until it is let go, so that the queue's order can be arranged.
class Gate {
 public:
  explicit Gate(Executor& executor) {
    executor.submit(1e9, [this] {
      entered_.release();
      open_.acquire();
    });
    entered_.acquire();
  }
  void open() { open_.release(); }

 private:
  std::binary_semaphore entered_{0};
  std::binary_semaphore open_{0};
};

// What ran, in order, and a wait for the last.
class Log {
 public:
  std::function<void()> entry(std::string name) {
    return [this, name = std::move(name)] {
      const std::scoped_lock lock(mutex_);
      names_ += name;
    };
  }
  std::string names() const {
    const std::scoped_lock lock(mutex_);
    return names_;
  }

 private:
  mutable std::mutex mutex_;
  std::string names_;
};

void drain(Executor& executor) {
  std::binary_semaphore done{0};
  executor.submit(-std::numeric_limits<double>::infinity(), [&done] { done.release(); });
  done.acquire();
}

TEST(Executor, HasAtLeastOneThread) {
  EXPECT_GE(Executor().threadCount(), 1);
  EXPECT_EQ(Executor(3).threadCount(), 3);
}

#ifdef __linux__
TEST(Executor, workersInTheBackgroundAndOnlyTheyStepBack) {
  const int before = getpriority(PRIO_PROCESS, 0);
  int policy = -1;
  const auto niceOfAWorker = [&policy](Executor::Share share) {
    Executor executor(1, share);
    int nice = 0;
    std::binary_semaphore done{0};
    executor.submit(0.0, [&] {
      nice = getpriority(PRIO_PROCESS, 0);
      policy = sched_getscheduler(0);
      done.release();
    });
    done.acquire();
    return nice;
  };
  const int policyBefore = sched_getscheduler(0);
  EXPECT_EQ(niceOfAWorker(Executor::Share::equal), before);
  EXPECT_EQ(policy, policyBefore);
  EXPECT_EQ(niceOfAWorker(Executor::Share::background), std::min(before + 5, 19));
  EXPECT_EQ(policy, SCHED_BATCH) << "who wakes it goes on itself";
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), before);
}
#endif

TEST(Executor, RunsByPriorityThenByArrival) {
  Executor executor(1);
  Log log;
  Gate gate(executor);
  executor.submit(1.0, log.entry("c"));
  executor.submit(3.0, log.entry("a"));
  executor.submit(1.0, log.entry("d"));
  executor.submit(2.0, log.entry("b"));
  executor.submit(std::numeric_limits<double>::quiet_NaN(), log.entry("e"));
  EXPECT_EQ(executor.waiting(), 5u);
  gate.open();
  drain(executor);
  EXPECT_EQ(log.names(), "abcde");
  EXPECT_EQ(executor.waiting(), 0u);
}

TEST(Executor, PriorityCanChangeWhileTheTaskWaits) {
  Executor executor(1);
  Log log;
  Gate gate(executor);
  const Executor::Task first = executor.submit(5.0, log.entry("x"));
  executor.submit(3.0, log.entry("y"));
  const Executor::Task last = executor.submit(1.0, log.entry("z"));
  first.setPriority(2.0);
  last.setPriority(4.0);
  gate.open();
  drain(executor);
  EXPECT_EQ(log.names(), "zyx");
  last.setPriority(7.0);  // has ended: nothing happens
  EXPECT_EQ(executor.waiting(), 0u);
}

TEST(Executor, CancelledTaskNeverRunsAndLetsGoOfItsClosure) {
  Executor executor(1);
  Log log;
  Gate gate(executor);
  const auto held = std::make_shared<int>(1);
  const Executor::Task task = executor.submit(1.0, [held, entry = log.entry("no")] { entry(); });
  EXPECT_EQ(held.use_count(), 2);
  task.cancel();
  EXPECT_EQ(held.use_count(), 1);
  EXPECT_EQ(executor.waiting(), 0u);
  task.cancel();
  task.setPriority(9.0);
  EXPECT_EQ(executor.waiting(), 0u);
  gate.open();
  drain(executor);
  EXPECT_EQ(log.names(), "");
}

TEST(Executor, EmptyHandleAndEmptyWorkDoNothing) {
  Executor executor(1);
  const Executor::Task none;
  none.cancel();
  none.setPriority(1.0);
  executor.submit(1.0, {}).cancel();
  drain(executor);
}

TEST(Executor, DestructionDropsWhatWaitsAndFinishesWhatRuns) {
  std::atomic<int> finished = 0;
  std::atomic<int> dropped = 0;
  const auto held = std::make_shared<int>(1);
  Executor::Task handle;
  {
    Executor executor(1);
    std::binary_semaphore begun{0};
    executor.submit(2.0, [&] {
      begun.release();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      ++finished;
      executor.submit(3.0, [&dropped] { ++dropped; });  // handed in while the executor goes: dropped too
    });
    begun.acquire();
    handle = executor.submit(1.0, [&dropped, held] { ++dropped; });
  }
  EXPECT_EQ(finished, 1);
  EXPECT_EQ(dropped, 0);
  EXPECT_EQ(held.use_count(), 1);
  handle.cancel();  // outlives its executor
  handle.setPriority(1.0);
}

TEST(Executor, ManyThreadsRunEveryTaskOnce) {
  constexpr int kTasks = 20000;
  std::vector<std::atomic<int>> runs(kTasks);
  {
    Executor executor(4);
    std::vector<Executor::Task> tasks;
    for (int i = 0; i < kTasks; ++i) {
      tasks.push_back(executor.submit(i % 17, [&runs, i] { ++runs[static_cast<std::size_t>(i)]; }));
      if (i % 3 == 0) tasks.back().setPriority(i % 5);
      if (i % 11 == 0) tasks.back().cancel();
    }
    while (executor.waiting() > 0)
      std::this_thread::yield();
  }
  for (std::size_t i = 0; i < runs.size(); ++i) {
    ASSERT_LE(runs[i], 1) << i;
    ASSERT_TRUE(runs[i] == 1 || i % 11 == 0) << i;  // only the cancelled ones may be missing
  }
}

TEST(Executor, TasksMaySubmitTasks) {
  Executor executor(2);
  std::counting_semaphore<16> done{0};
  for (int i = 0; i < 8; ++i) {
    executor.submit(0.0, [&] { executor.submit(1.0, [&done] { done.release(); }); });
  }
  for (int i = 0; i < 8; ++i)
    done.acquire();
}

}  // namespace
}  // namespace tellurion::io
