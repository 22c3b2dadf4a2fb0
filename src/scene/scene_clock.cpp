#include "scene/scene_clock.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace tellurion::scene {
namespace {

constexpr double kDay_s = 86400.0;
constexpr double kFirst_s = -62167219200.0;  // 0000-01-01T00:00:00Z
constexpr double kLast_s = 253402300799.0;   // 9999-12-31T23:59:59Z

std::chrono::sys_days newYear(int year) {
  return std::chrono::sys_days(std::chrono::year(year) / std::chrono::January / 1);
}

}  // namespace

std::optional<double> timeAfter(const SceneClock& clock, double seconds) {
  if (!clock.start_s) return std::nullopt;
  const double time_s = *clock.start_s + clock.rate * seconds;
  const bool hasEnd = clock.end_s && (*clock.end_s - *clock.start_s) * clock.rate > 0.0;
  if (!hasEnd) return time_s;
  return clock.rate > 0.0 ? std::min(time_s, *clock.end_s) : std::max(time_s, *clock.end_s);
}

CalendarTime calendarTimeOf(double time_s) {
  const double within_s = time_s > kFirst_s ? std::min(time_s, kLast_s) : kFirst_s;  // NaN is not larger
  const double days = std::floor(within_s / kDay_s);
  const std::chrono::sys_days date{std::chrono::days(static_cast<int>(days))};
  const int year = static_cast<int>(std::chrono::year_month_day(date).year());
  return {.year = year,
          .day = static_cast<int>((date - newYear(year)).count()) + 1,
          .hour = (within_s - days * kDay_s) / 3600.0};
}

double secondsOf(const CalendarTime& time) {
  const double days = static_cast<double>(newYear(time.year).time_since_epoch().count()) + (time.day - 1);
  return std::round((days * kDay_s + time.hour * 3600.0) * 1e6) / 1e6;
}

int daysOfYear(int year) {
  return std::chrono::year(year).is_leap() ? 366 : 365;
}

}  // namespace tellurion::scene
