#include "io/fetch_queue.h"

#include <gmock/gmock.h>

#include <algorithm>

namespace tellurion::io {
namespace {

constexpr Backoff kBackoff{.first_s = 1.0, .longest_s = 60.0};
constexpr double kMostSpread = 1.2;

SteadyTime at(double seconds) {
  return SteadyTime{} +
         std::chrono::duration_cast<SteadyTime::duration>(std::chrono::duration<double>(1000.0 + seconds));
}
// Rounded up: at() of it is not before.
double secondsOf(SteadyTime time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count() - 1000.0 + 1e-6;
}

Fetcher::Id add(FetchQueue& queue, const std::string& host, const std::string& url, double priority = 1.0) {
  return queue.add(host, {.url = url}, priority, nullptr);
}
FailedRequest failure(const FetchJobPointer& job, bool wholeHost = false) {
  return {.url = job->request.url, .reason = "broken", .wholeHost = wholeHost};
}

TEST(Backoff, DoublesUpToAMinute) {
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(1, 0.5), 1.0);
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(2, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(6, 0.5), 32.0);
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(7, 0.5), 60.0);
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(1'000'000, 0.5), 60.0);
  EXPECT_DOUBLE_EQ(kBackoff.delay_s(1, 0.0), 0.8);
  EXPECT_LE(kBackoff.delay_s(1, 0.999), 1.2);
}

// A host that fails for an hour: after the first few, one request at a time, ever more seldom, once a minute in the
// end.
TEST(FetchQueue, AFailingHostIsLeftInPeace) {
  FetchQueue queue(kBackoff, 6);
  for (int i = 0; i < 100; ++i)
    add(queue, "host", "url" + std::to_string(i));
  std::vector<double> times;
  double now = 0.0;
  while (now < 3600.0) {
    queue.wake(at(now));
    std::vector<FetchJobPointer> sent;
    while (const FetchJobPointer job = queue.next(at(now)))
      sent.push_back(job);
    EXPECT_LE(sent.size(), times.empty() ? 6U : 1U);
    for (const FetchJobPointer& job : sent) {
      times.push_back(now);
      queue.failed(job, failure(job), at(now));
    }
    const auto wake = queue.wakeTime();
    ASSERT_TRUE(wake);
    now = std::max(now + 0.001, secondsOf(*wake));
  }
  EXPECT_LE(times.size(), 6U + 8U + 3600U / 48U);
  EXPECT_GE(times.size(), 6U + 3600U / 73U);
  ASSERT_EQ(queue.troubles(at(now)).size(), 1U);
  EXPECT_THAT(queue.troubles(at(now)).front().message, testing::HasSubstr("broken"));

  // Well again: the probe succeeds, and the rest goes out at once.
  now += 100.0;
  queue.wake(at(now));
  const FetchJobPointer probe = queue.next(at(now));
  ASSERT_NE(probe, nullptr);
  EXPECT_EQ(queue.next(at(now)), nullptr);
  queue.succeeded(probe);
  for (int i = 0; i < 6; ++i)
    EXPECT_NE(queue.next(at(now)), nullptr);
  EXPECT_EQ(queue.next(at(now)), nullptr);
  EXPECT_TRUE(queue.troubles(at(now)).empty());
}

// Probes take turns: one URL that never comes does not keep a host in trouble.
TEST(FetchQueue, AProbeThatFailsLetsAnotherGo) {
  FetchQueue queue(kBackoff, 6);
  for (int i = 0; i < 3; ++i)
    add(queue, "host", "bad" + std::to_string(i), 10.0);
  for (int i = 0; i < 3; ++i) {
    const FetchJobPointer job = queue.next(at(0.0));
    queue.failed(job, failure(job), at(0.0));
  }
  add(queue, "host", "good", 1.0);
  double now = 0.0;
  for (int round = 0; round < 5; ++round) {
    now = std::max(now, secondsOf(*queue.wakeTime()));
    queue.wake(at(now));
    const FetchJobPointer job = queue.next(at(now));
    if (!job) continue;
    if (job->request.url == "good") return;
    queue.failed(job, failure(job), at(now));
  }
  FAIL() << "the good one never went out";
}

TEST(FetchQueue, OneUrlThatFailsIsNotItsHost) {
  FetchQueue queue(kBackoff, 6);
  add(queue, "host", "bad");
  double now = 0.0;
  int sent = 0;
  for (; now < 600.0; now = secondsOf(*queue.wakeTime())) {
    queue.wake(at(now));
    const FetchJobPointer job = queue.next(at(now));
    ASSERT_NE(job, nullptr);
    EXPECT_FALSE(job->probe);
    queue.failed(job, failure(job), at(now));
    ++sent;
    add(queue, "host", "good");
    const FetchJobPointer good = queue.next(at(now));
    ASSERT_NE(good, nullptr);
    queue.succeeded(good);
    EXPECT_EQ(queue.troubles(at(now)).size(), 1U);
  }
  EXPECT_GE(sent, 6 + 6);
  EXPECT_LE(sent, 8 + 12);
}

TEST(FetchQueue, TroublesCountOnlyRequestsThatWait) {
  FetchQueue queue(kBackoff, 6);
  add(queue, "host", "a");
  const FetchJobPointer job = queue.next(at(0.0));
  ASSERT_NE(job, nullptr);
  queue.failed(job, failure(job), at(0.0));
  ASSERT_EQ(queue.troubles(at(0.0)).size(), 1U);
  EXPECT_THAT(queue.troubles(at(0.0)).front().message, testing::HasSubstr("; 1 request of it made again, the next in"));
  const double now = secondsOf(*queue.wakeTime());
  queue.wake(at(now));
  ASSERT_NE(queue.next(at(now)), nullptr);
  ASSERT_EQ(queue.troubles(at(now)).size(), 1U);
  EXPECT_EQ(queue.troubles(at(now)).front().message, "broken") << "it is being asked for again now";
}

TEST(FetchQueue, WhatTheServerWishesIsHonoured) {
  FetchQueue queue(kBackoff, 6);
  add(queue, "host", "a");
  add(queue, "host", "b");
  add(queue, "other", "c", -5.0);
  FailedRequest how = failure(queue.next(at(0.0)), true);
  how.url = "a";
  how.retryAfter_s = 300.0;
  FetchQueue fresh(kBackoff, 6);
  add(fresh, "host", "a");
  add(fresh, "host", "b");
  add(fresh, "other", "c", -5.0);
  fresh.failed(fresh.next(at(0.0)), how, at(0.0));
  EXPECT_EQ(fresh.next(at(0.0))->request.url, "c");
  fresh.wake(at(299.0));
  EXPECT_EQ(fresh.next(at(299.0)), nullptr);
  fresh.wake(at(300.0));
  EXPECT_NE(fresh.next(at(300.0)), nullptr);
  EXPECT_EQ(fresh.next(at(300.0)), nullptr);
}

TEST(FetchQueue, WhoHasAnOlderCopyDoesNotWait) {
  FetchQueue queue(kBackoff, 6);
  add(queue, "host", "a");
  queue.add("host", {.url = "old", .onlyIfWell = true}, 0.0, nullptr);
  EXPECT_TRUE(queue.givenUp().empty());
  const FetchJobPointer job = queue.next(at(0.0));
  EXPECT_FALSE(queue.failed(job, failure(job, true), at(0.0)));
  const auto givenUp = queue.givenUp();
  ASSERT_EQ(givenUp.size(), 1U);
  EXPECT_EQ(givenUp.front()->request.url, "old");
  EXPECT_TRUE(queue.givenUp().empty());
}

TEST(FetchQueue, ACancelledProbeLetsAnotherFindOut) {
  FetchQueue queue(kBackoff, 6);
  add(queue, "host", "a", 9.0);
  const Fetcher::Id b = add(queue, "host", "b");
  const FetchJobPointer first = queue.next(at(0.0));
  queue.failed(first, failure(first, true), at(0.0));
  queue.wake(at(10.0));
  const FetchJobPointer probe = queue.next(at(10.0));
  ASSERT_EQ(probe->id, b) << "it has failed less often";
  EXPECT_EQ(queue.next(at(10.0)), nullptr);
  EXPECT_EQ(queue.cancel(b), probe);
  queue.stopped(probe);
  EXPECT_EQ(queue.next(at(10.0))->request.url, "a");
}

// Random use against the rules: never more than allowed at once, the most urgent first, nothing lost, nothing twice.
TEST(FetchQueue, KeepsItsRulesUnderAnyUse) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    FetchQueue queue(kBackoff, 4);
    std::map<Fetcher::Id, double> open;  // not ended yet
    std::vector<FetchJobPointer> running;
    double now = 0.0;
    const auto runningOf = [&](const FetchHost* host) {
      return std::ranges::count_if(running, [&](const FetchJobPointer& job) { return job->host == host; });
    };
    for (int step = 0; step < 2000; ++step) {
      now += static_cast<double>(random() % 100) / 200.0;
      queue.wake(at(now));
      const double priority = static_cast<double>(random() % 10);
      switch (random() % 6) {
        case 0:
        case 1:
          open[add(queue, "host" + std::to_string(random() % 3), std::to_string(step), priority)] = priority;
          break;
        case 2: {
          const FetchJobPointer job = queue.next(at(now));
          if (!job) break;
          ASSERT_EQ(open.count(job->id), 1U);
          EXPECT_TRUE(std::ranges::find(running, job) == running.end());
          for (const FetchJobPointer& other : job->host->queued)
            EXPECT_TRUE(job->probe ? other->tries >= job->tries : other->priority <= job->priority);
          running.push_back(job);
          EXPECT_LE(runningOf(job->host), 4 + 1);
          break;
        }
        case 3:
        case 4: {
          if (running.empty()) break;
          const std::size_t which = random() % running.size();
          const FetchJobPointer job = running[which];
          running.erase(running.begin() + static_cast<std::ptrdiff_t>(which));
          if (random() % 3 == 0) {
            queue.failed(job, failure(job, random() % 4 == 0), at(now));
          } else {
            queue.succeeded(job);
            open.erase(job->id);
          }
          break;
        }
        default: {
          if (open.empty()) break;
          auto one = open.begin();
          std::advance(one, static_cast<std::ptrdiff_t>(random() % open.size()));
          if (random() % 2 == 0) {
            queue.setPriority(one->first, priority);
            break;
          }
          if (const FetchJobPointer job = queue.cancel(one->first)) {
            std::erase(running, job);
            queue.stopped(job);
          }
          open.erase(one);
        }
      }
    }
    // Everything that was not cancelled comes in the end.
    for (int step = 0; step < 20'000 && !(open.empty() && running.empty()); ++step) {
      now += 1.0;
      queue.wake(at(now));
      while (const FetchJobPointer job = queue.next(at(now)))
        running.push_back(job);
      for (const FetchJobPointer& job : std::exchange(running, {})) {
        queue.succeeded(job);
        open.erase(job->id);
      }
    }
    EXPECT_TRUE(open.empty()) << "seed " << seed;
    EXPECT_FALSE(queue.wakeTime()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace tellurion::io
