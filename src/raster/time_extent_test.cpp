#include "raster/time_extent.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

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

/// All steps of spans of seconds, spelled out.
std::vector<double> lastOf(std::span<const TimeSpan> extent, std::size_t most) {
  std::set<double> all;
  for (const TimeSpan& span : extent) {
    const double period_s = std::stod(span.period.substr(2));
    for (double time_s = *secondsOfTime(span.start); time_s <= *secondsOfTime(span.end); time_s += period_s)
      all.insert(time_s);
  }
  std::vector<double> times(all.begin(), all.end());
  return {times.end() - static_cast<std::ptrdiff_t>(std::min(most, times.size())), times.end()};
}

TEST(TimeSteps, areTheLastOfAllSpansWhateverTheirOrder) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 200; ++i) {
    std::vector<TimeSpan> extent;
    const double spans = geo::uniform(random, 1.0, 9.0);
    for (int k = 0; k < static_cast<int>(spans); ++k) {
      const double start_s = std::floor(geo::uniform(random, 0.0, 3e4));
      extent.push_back({.start = isoTime(start_s),
                        .end = isoTime(start_s + geo::uniform(random, 1.0, 3e4)),
                        .period = fmt::format("PT{}S", static_cast<int>(geo::uniform(random, 1.0, 2000.0)))});
    }
    const auto most = static_cast<std::size_t>(geo::uniform(random, 1.0, 300.0));
    std::vector<double> times;
    for (const TimeStep& step : timeSteps(extent, most))
      times.push_back(step.time_s);
    EXPECT_EQ(times, lastOf(extent, most));
  }
}

TEST(TimeSteps, monthsEndWhereTheCalendarSays) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 300; ++i) {
    const double start_s = std::floor(geo::uniform(random, -6e10, 2e11) / 86400.0) * 86400.0;
    const std::string start = isoTime(start_s);
    const std::string period = fmt::format("P{}M", static_cast<int>(geo::uniform(random, 1.0, 40.0)));
    const auto all = timeSteps(parseTimeExtent(fmt::format("{}/9999-12-31/{}", start, period)), 1'000'000);
    ASSERT_GT(all.size(), 3u);
    const auto k = static_cast<std::size_t>(geo::uniform(random, 1.0, static_cast<double>(all.size())));
    const auto part = timeSteps(parseTimeExtent(fmt::format("{}/{}/{}", start, all[k].name, period)), 1'000'000);
    ASSERT_EQ(part.size(), k + 1) << start << ' ' << period << ' ' << all[k].name;
    EXPECT_EQ(part.back().time_s, all[k].time_s);
  }
}

TEST(TimeSteps, hostileExtentsAreBounded) {
  std::string seconds;
  for (int i = 0; i < 3000; ++i)
    seconds += fmt::format("{}0001-01-01T00:{:02}:{:02}Z/9999-12-31T23:59:59Z/PT1S", i == 0 ? "" : ",", i / 60, i % 60);
  const auto steps = timeSteps(parseTimeExtent(seconds), 20'000);
  ASSERT_EQ(steps.size(), 20'000u);
  EXPECT_EQ(steps.back().name, "9999-12-31T23:59:59Z");
  EXPECT_EQ(steps.back().time_s - steps.front().time_s, 19'999.0);
  std::string years;
  for (int i = 0; i < 300'000; ++i)
    years += "9999Y99999M";
  EXPECT_EQ(namesOf("2000/9999/P" + years), Names{"2000"}) << "a sum beyond an int";
  EXPECT_EQ(namesOf("2000/9999/P9999Y"), Names{"2000"});
  EXPECT_EQ(namesOf("2000-01-01T00:00:00Z/2000-01-01T00:00:02Z/PT0.000000001S").size(), 3u);
  EXPECT_EQ(namesOf("2000-01-01T00:00:00Z/2000-01-01T00:00:02Z/PT0." + std::string(300, '0') + "1S").size(), 3u);
  std::string many;
  for (int i = 0; i < 300'000; ++i)
    many += "1,";
  EXPECT_EQ(parseTimeExtent(many + "2000").size(), 100'000u);
  EXPECT_EQ(parseTimeExtent(many + "2000").back().start, "2000");
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
