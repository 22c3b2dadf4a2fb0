#include "raster/time_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>

namespace tellurion::raster {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpace);
  return first == text.npos ? std::string_view{} : text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

/// Takes a number of exactly `digits` digits off the front.
bool takeNumber(std::string_view& text, std::size_t digits, int& value) {
  if (text.size() < digits) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + digits, value);
  if (error != std::errc{} || end != text.data() + digits || text[0] == '-') return false;
  text.remove_prefix(digits);
  return true;
}

bool take(std::string_view& text, char c) {
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

/// Seconds east of Greenwich: "Z", "+02:00" or nothing. False: something else.
bool takeZone(std::string_view& text, int& seconds) {
  if (text.empty() || take(text, 'Z') || take(text, 'z')) return text.empty();
  const int sign = text[0] == '-' ? -1 : 1;
  int hours = 0;
  int minutes = 0;
  if (!take(text, '+') && !take(text, '-')) return false;
  if (!takeNumber(text, 2, hours)) return false;
  take(text, ':');
  if (!text.empty() && !takeNumber(text, 2, minutes)) return false;
  seconds = sign * (hours * 3600 + minutes * 60);
  return text.empty();
}

/// hh[:mm[:ss[.fraction]]] off the front.
bool takeTimeOfDay(std::string_view& text, double& seconds) {
  std::array<int, 3> parts{};
  if (!takeNumber(text, 2, parts[0])) return false;
  for (std::size_t i = 1; i < parts.size() && take(text, ':'); ++i)
    if (!takeNumber(text, 2, parts[i])) return false;
  seconds = parts[0] * 3600.0 + parts[1] * 60.0 + parts[2];
  if (!text.starts_with('.')) return parts[0] <= 24 && parts[1] < 60 && parts[2] <= 60;
  double fraction = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), fraction, std::chars_format::fixed);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  seconds += fraction;
  return parts[0] <= 24 && parts[1] < 60 && parts[2] <= 60;
}

/// Whole months, and seconds.
struct Period {
  int months = 0;
  double seconds = 0.0;
};

/// "P1Y2M10DT2H30M", "P2W".
std::optional<Period> periodFrom(std::string_view text) {
  if (!take(text, 'P')) return std::nullopt;
  Period out;
  bool isTime = false;
  while (!text.empty()) {
    if (take(text, 'T')) {
      isTime = true;
      continue;
    }
    double count = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count, std::chars_format::fixed);
    if (error != std::errc{} || end == text.data() + text.size() || !(count >= 0.0 && count < 1e9)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (!isTime && take(text, 'Y')) {
      out.months += 12 * static_cast<int>(std::min(count, 1e4));
    } else if (!isTime && take(text, 'M')) {
      out.months += static_cast<int>(std::min(count, 1e5));
    } else if (!isTime && take(text, 'W')) {
      out.seconds += 7 * 86400.0 * count;
    } else if (!isTime && take(text, 'D')) {
      out.seconds += 86400.0 * count;
    } else if (isTime && take(text, 'H')) {
      out.seconds += 3600.0 * count;
    } else if (isTime && take(text, 'M')) {
      out.seconds += 60.0 * count;
    } else if (isTime && take(text, 'S')) {
      out.seconds += count;
    } else {
      return std::nullopt;
    }
  }
  return out.months > 0 || out.seconds > 0.0 ? std::optional(out) : std::nullopt;
}

/// Months later, on the same day or the month's last; then the seconds.
double later(double start_s, const Period& period, double times) {
  if (period.months == 0) return start_s + times * period.seconds;
  const double days = std::floor(start_s / 86400.0);
  const std::chrono::year_month_day date(std::chrono::sys_days(std::chrono::days(static_cast<int>(days))));
  const auto month = date.year() / date.month() + std::chrono::months(period.months * static_cast<int>(times));
  const std::chrono::year_month_day_last last(month.year(), std::chrono::month_day_last(month.month()));
  const auto whole = std::chrono::sys_days(month / std::min(date.day(), last.day())).time_since_epoch().count();
  return static_cast<double>(whole) * 86400.0 + (start_s - days * 86400.0) + times * period.seconds;
}

/// Those of a span, named as exactly as its start.
void addSteps(const TimeSpan& span, std::size_t most, std::vector<TimeStep>& steps) {
  const auto start = secondsOfTime(span.start);
  if (!start) return;
  steps.push_back({.time_s = *start, .name = span.start});
  const auto end = secondsOfTime(span.end);
  if (!end || !(*end > *start)) return;
  const auto period = periodFrom(span.period);
  if (!period) {
    steps.push_back({.time_s = *end, .name = span.end});
    return;
  }
  double index = 1.0;
  if (period->months == 0)
    index = std::max(1.0, std::floor((*end - *start) / period->seconds) - static_cast<double>(most));
  const bool isDay = span.start.find('T') == std::string::npos && std::fmod(period->seconds, 86400.0) == 0.0;
  for (std::size_t i = 0; i <= most; ++i, index += 1.0) {
    const double time_s = later(*start, *period, index);
    if (time_s > *end) return;
    steps.push_back({.time_s = time_s, .name = isoTime(time_s).substr(0, isDay ? 10 : 20)});
  }
}

}  // namespace

std::vector<TimeStep> timeSteps(std::span<const TimeSpan> extent, std::size_t most) {
  std::vector<TimeStep> steps;
  for (const TimeSpan& span : extent) {
    addSteps(span, most, steps);
    if (steps.size() <= 4 * most) continue;
    std::ranges::stable_sort(steps, {}, &TimeStep::time_s);
    steps.erase(steps.begin(), steps.end() - static_cast<std::ptrdiff_t>(most));
  }
  std::ranges::stable_sort(steps, {}, &TimeStep::time_s);
  const auto [first, last] = std::ranges::unique(steps, {}, &TimeStep::time_s);
  steps.erase(first, last);
  if (steps.size() > most) steps.erase(steps.begin(), steps.end() - static_cast<std::ptrdiff_t>(most));
  return steps;
}

std::string isoTime(double time_s) {
  const double days = std::floor(time_s / 86400.0);
  const std::chrono::year_month_day date(std::chrono::sys_days(std::chrono::days(static_cast<int>(days))));
  const int seconds = static_cast<int>(time_s - days * 86400.0);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), seconds / 3600,
                     seconds / 60 % 60, seconds % 60);
}

std::vector<TimeSpan> parseTimeExtent(std::string_view text) {
  std::vector<TimeSpan> extent;
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    std::string_view part = trimmed(text.substr(0, comma));
    text = comma == text.npos ? std::string_view{} : text.substr(comma + 1);
    if (part.empty()) continue;
    TimeSpan& span = extent.emplace_back();
    for (std::string* field : {&span.start, &span.end, &span.period}) {
      const std::size_t slash = part.find('/');
      *field = trimmed(part.substr(0, slash));
      if (slash == part.npos) break;
      part = part.substr(slash + 1);
    }
  }
  return extent;
}

std::optional<double> secondsOfTime(std::string_view iso) {
  iso = trimmed(iso);
  int year = 0;
  int month = 1;
  int day = 1;
  if (!takeNumber(iso, 4, year)) return std::nullopt;
  const bool dashes = take(iso, '-');
  const auto hasDigit = [&] { return !iso.empty() && iso[0] >= '0' && iso[0] <= '9'; };
  if ((dashes || hasDigit()) && !takeNumber(iso, 2, month)) return std::nullopt;
  if ((dashes ? take(iso, '-') : hasDigit()) && !takeNumber(iso, 2, day)) return std::nullopt;
  double timeOfDay_s = 0.0;
  int zone_s = 0;
  if ((take(iso, 'T') || take(iso, ' ')) && !takeTimeOfDay(iso, timeOfDay_s)) return std::nullopt;
  if (!takeZone(iso, zone_s)) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok()) return std::nullopt;
  return static_cast<double>(std::chrono::sys_days(date).time_since_epoch().count()) * 86400.0 + timeOfDay_s - zone_s;
}

bool offersTime(std::span<const TimeSpan> extent, std::string_view iso) {
  const auto time = secondsOfTime(iso);
  if (!time) return true;
  return std::ranges::any_of(extent, [&](const TimeSpan& span) {
    const auto start = secondsOfTime(span.start);
    const auto end = secondsOfTime(span.end);
    if (span.end.empty()) return !start || *start == *time;
    return (!start || *start <= *time) && (!end || *time <= *end);
  });
}

std::string lastTime(std::span<const TimeSpan> extent) {
  std::string last;
  for (const TimeSpan& span : extent) {
    const std::string& time = span.end.empty() ? span.start : span.end;
    const auto mine = secondsOfTime(time);
    const auto best = secondsOfTime(last);
    if (last.empty() || (mine && (!best || *mine > *best))) last = time;
  }
  return last;
}

std::string describeTimes(std::span<const TimeSpan> extent) {
  const auto one = [](const TimeSpan& span) {
    if (span.end.empty()) return span.start;
    return span.start + " to " + span.end + (span.period.empty() ? "" : " every " + span.period);
  };
  if (extent.empty()) return {};
  if (extent.size() == 1) return one(extent[0]);
  const std::string& end = extent.back().end.empty() ? extent.back().start : extent.back().end;
  const bool instants = std::ranges::all_of(extent, [](const TimeSpan& span) { return span.end.empty(); });
  return fmt::format("{} {}, {} to {}", extent.size(), instants ? "times" : "spans of time", extent[0].start, end);
}

}  // namespace tellurion::raster
