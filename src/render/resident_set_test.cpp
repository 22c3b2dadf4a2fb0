#include "render/resident_set.h"

#include <gtest/gtest.h>

namespace tellurion::render {
namespace {

TEST(ResidentSet, FindsOnlyWhatItHolds) {
  ResidentSet<int> set;
  EXPECT_EQ(set.touch(7, 1), nullptr);
  set.insert(7, 1, 70);
  ASSERT_NE(set.touch(7, 2), nullptr);
  EXPECT_EQ(*set.touch(7, 2), 70);
  EXPECT_EQ(set.size(), 1u);
}

TEST(ResidentSet, TheOneUsedLongestAgoLeavesFirst) {
  ResidentSet<int> set;
  set.insert(1, 1, 10);
  set.insert(2, 2, 20);
  set.insert(3, 3, 30);
  set.touch(1, 4);
  EXPECT_EQ(set.evictOldest(5), 20);
  EXPECT_EQ(set.evictOldest(5), 30);
  EXPECT_EQ(set.evictOldest(5), 10);
  EXPECT_EQ(set.evictOldest(5), std::nullopt);
  EXPECT_EQ(set.touch(1, 6), nullptr);
}

TEST(ResidentSet, NothingOfThisFrameLeaves) {
  ResidentSet<int> set;
  set.insert(1, 1, 10);
  set.insert(2, 2, 20);
  EXPECT_EQ(set.evictOldest(2), 10);
  EXPECT_EQ(set.evictOldest(2), std::nullopt);
  EXPECT_EQ(set.size(), 1u);
}

TEST(ResidentSet, PlacesStayWhereTheyAreWhileOthersComeAndGo) {
  ResidentSet<int> set;
  const int* place = set.insert(1, 9, 10);
  for (std::uint64_t serial = 2; serial < 200; ++serial)
    set.insert(serial, 1, static_cast<int>(serial));
  while (set.evictOldest(9)) {
  }
  EXPECT_EQ(set.touch(1, 9), place);
  EXPECT_EQ(*place, 10);
}

}  // namespace
}  // namespace tellurion::render
