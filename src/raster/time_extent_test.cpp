#include "raster/time_extent.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

std::vector<std::string> namesOf(std::string_view extent, std::size_t most = 100) {
  std::vector<std::string> out;
  for (const TimeStep& step : timeSteps(parseTimeExtent(extent), most)) {
    EXPECT_EQ(secondsOfTime(step.name), step.time_s) << step.name;
    out.push_back(step.name);
  }
  return out;
}
using Names = std::vector<std::string>;

TEST(TimeSteps, instantsAreThoseThatAreNamedInTheOrderOfTime) {
  EXPECT_EQ(namesOf("2004-02-01,2004-01,2004-02-01T00:00:00Z,current"), (Names{"2004-01", "2004-02-01"}));
  EXPECT_EQ(namesOf(""), Names{});
}

TEST(TimeSteps, periodsGoByTheCalendar) {
  EXPECT_EQ(namesOf("2004-01-31/2004-05-31/P1M"),
            (Names{"2004-01-31", "2004-02-29", "2004-03-31", "2004-04-30", "2004-05-31"}));
  EXPECT_EQ(namesOf("2000/2004/P2Y"), (Names{"2000", "2002-01-01", "2004-01-01"}));
  EXPECT_EQ(namesOf("2003-12-30/2004-01-02/P1D"), (Names{"2003-12-30", "2003-12-31", "2004-01-01", "2004-01-02"}));
  EXPECT_EQ(namesOf("2004-02-28T23:30:00Z/2004-02-29T00:30:00Z/PT30M"),
            (Names{"2004-02-28T23:30:00Z", "2004-02-29T00:00:00Z", "2004-02-29T00:30:00Z"}));
  EXPECT_EQ(namesOf("2004-01-01/2004-01-20/P1W"), (Names{"2004-01-01", "2004-01-08", "2004-01-15"}));
}

TEST(TimeSteps, aSpanWithoutAPeriodIsItsEnds) {
  EXPECT_EQ(namesOf("2004/2005"), (Names{"2004", "2005"}));
  EXPECT_EQ(namesOf("2004/2005/P"), (Names{"2004", "2005"}));
  EXPECT_EQ(namesOf("2004/2003/P1D"), Names{"2004"});
}

TEST(TimeSteps, ofTooManyTheLastCount) {
  const auto days = namesOf("1900-01-01/2020-12-31/P1D", 3);
  EXPECT_EQ(days, (Names{"2020-12-29", "2020-12-30", "2020-12-31"}));
  EXPECT_EQ(namesOf("2000-01-01T00:00:00Z/2020-01-01T00:00:00Z/PT1S", 1), Names{"2020-01-01T00:00:00Z"});
}

TEST(TimeSteps, isoTimeReadsBack) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 1000; ++i) {
    const double time_s = std::floor(geo::uniform(random, -6e10, 2.5e11));
    EXPECT_EQ(secondsOfTime(isoTime(time_s)), time_s) << isoTime(time_s);
  }
  EXPECT_EQ(isoTime(1088683200.9), "2004-07-01T12:00:00Z");
}

}  // namespace
}  // namespace tellurion::raster
