#include "io/slow_answers.h"

#include <gtest/gtest.h>

namespace tellurion::io {
namespace {

using namespace std::chrono_literals;

TEST(SlowAnswers, nameTheHostsThatHardlyAnswerAndNoOther) {
  const SteadyTime now = SteadyTime{} + 1h;
  const std::vector<OpenAnswer> open{
      {.host = "http://hangs", .since = now - 5s, .bytes = 0},
      {.host = "http://hangs", .since = now - 3s, .bytes = 300},
      {.host = "http://begun", .since = now - 900ms, .bytes = 0},
      {.host = "http://narrow", .since = now - 4s, .bytes = 5000},
      {.host = "http://trickles", .since = now - 20s, .bytes = 2000},
  };
  const std::vector<Failure> told = slowAnswers(open, now);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(describe(told[0]), "http://hangs: hardly answers: 2 of its answers under way, 300 bytes of them in 5 s");
  EXPECT_EQ(told[1].where, "http://trickles");
}

}  // namespace
}  // namespace tellurion::io
