#include "raster/time_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>

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

}  // namespace

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
