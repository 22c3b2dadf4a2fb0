#include "scene/unused_records.h"

#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

TEST(UnusedRecords, leaveInTheOrderInWhichTheyCameWhoeverLeavesBetween) {
  std::mt19937_64 random = geo::seededGenerator();
  std::deque<TileRecord> records(50);
  UnusedRecords unused;
  std::deque<TileRecord*> expected;
  for (int i = 0; i < 20000; ++i) {
    TileRecord& r = records[random() % records.size()];
    if (random() % 3 == 0 && !expected.empty()) {
      ASSERT_EQ(unused.oldest(), expected.front());
      unused.remove(*expected.front());
      expected.pop_front();
    } else if (r.isUnused) {
      unused.remove(r);
      std::erase(expected, &r);
    } else {
      unused.add(r);
      expected.push_back(&r);
    }
    ASSERT_EQ(unused.oldest(), expected.empty() ? nullptr : expected.front());
  }
}

}  // namespace
}  // namespace tellurion::scene
