#include "pyramid/ordered_work.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <semaphore>
#include <thread>

#include "geo/seed_test.h"

namespace tellurion::pyramid {
namespace {

TEST(OrderedWork, ResultsComeInTheOrderOfTheirComing) {
  auto random = geo::seededGenerator();
  for (const int threads : {1, 2, 5}) {
    OrderedWork<int> work(threads, 7);
    int pushed = 0;
    int popped = 0;
    while (popped < 300) {
      const bool mayPush = pushed < 300 && !work.isFull();
      if (mayPush && (work.isEmpty() || random() % 3 != 0)) {
        const auto pause = std::chrono::microseconds(random() % 300);
        work.push([value = pushed, pause] {
          std::this_thread::sleep_for(pause);
          return value;
        });
        ++pushed;
      } else {
        ASSERT_EQ(work.pop(), popped);
        ++popped;
      }
    }
    EXPECT_TRUE(work.isEmpty());
  }
}

TEST(OrderedWork, TheWindowBoundsWhatWaits) {
  OrderedWork<int> work(2, 3);
  EXPECT_TRUE(work.isEmpty());
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(work.isFull());
    work.push([i] { return i; });
  }
  EXPECT_TRUE(work.isFull());  // also once the work is done: results wait too
  EXPECT_EQ(work.pop(), 0);
  EXPECT_FALSE(work.isFull());
}

TEST(OrderedWork, ASlowPieceHoldsTheResultsAfterItBackButNotTheWork) {
  OrderedWork<int> work(2, 8);
  std::binary_semaphore slow{0};
  std::counting_semaphore<> quick{0};
  work.push([&slow] {
    slow.acquire();
    return 0;
  });
  for (int i = 1; i < 4; ++i) {
    work.push([&quick, i] {
      quick.release();
      return i;
    });
  }
  for (int i = 1; i < 4; ++i)
    quick.acquire();  // all have run on the other thread while the first still waits
  slow.release();
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(work.pop(), i);
}

TEST(OrderedWork, ResultsNeedOnlyBeMovable) {
  OrderedWork<std::unique_ptr<int>> work(1, 2);
  work.push([] { return std::make_unique<int>(7); });
  EXPECT_EQ(*work.pop(), 7);
}

TEST(OrderedWork, DestructionDropsWhatHasNotBegunAndWaitsForWhatHas) {
  std::atomic<int> begun{0};
  std::atomic<int> ended{0};
  std::binary_semaphore inside{0};
  {
    OrderedWork<int> work(1, 100);
    for (int i = 0; i < 100; ++i) {
      work.push([&] {
        if (++begun == 1) inside.release();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        return ++ended;
      });
    }
    inside.acquire();
  }
  EXPECT_EQ(begun, ended);
  EXPECT_GE(begun, 1);
  EXPECT_LT(begun, 100);
}

}  // namespace
}  // namespace tellurion::pyramid
