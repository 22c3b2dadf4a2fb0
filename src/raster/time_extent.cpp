#include "raster/time_extent.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "raster/parse_number.h"

namespace tellurion::raster {
namespace {

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

constexpr int kMostMonths = 120'000;  // more than from year 0 to 9999

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
      out.months = std::min(out.months + 12 * static_cast<int>(std::min(count, 1e4)), kMostMonths);
    } else if (!isTime && take(text, 'M')) {
      out.months = std::min(out.months + static_cast<int>(std::min(count, 1e5)), kMostMonths);
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

/// A span that can be read: steps from start_s on, every period.
struct Run {
  double start_s = 0.0;
  double end_s = 0.0;  ///< none is later
  std::optional<Period> period;
  const TimeSpan* span = nullptr;

  double at(double index) const { return period ? later(start_s, *period, index) : start_s; }
  /// No step that is not after the end has a larger index.
  double lastIndex() const {
    if (!period) return 0.0;
    constexpr double kMeanMonth_s = 30.436875 * 86400.0;
    const double length_s = period->months * kMeanMonth_s + period->seconds;
    return std::floor((end_s - start_s) / length_s) + (period->months > 0 ? 2.0 : 1.0);
  }
};

/// In the order of the extent.
std::vector<Run> runsOf(std::span<const TimeSpan> extent) {
  std::vector<Run> runs;
  for (const TimeSpan& span : extent) {
    const auto start = secondsOfTime(span.start);
    if (!start) continue;
    Run run{*start, *start, std::nullopt, &span};
    const auto end = secondsOfTime(span.end);
    if (end && *end > *start) run.period = periodFrom(span.period);
    // Steps are named in whole seconds: finer ones would be the same.
    if (run.period && run.period->months == 0) run.period->seconds = std::max(run.period->seconds, 1.0);
    if (run.period) run.end_s = *end;
    runs.push_back(run);
    if (end && *end > *start && !run.period) runs.push_back({*end, *end, std::nullopt, &span});
  }
  return runs;
}

/// A step that has no name yet.
struct Found {
  double time_s = 0.0;
  bool isComputed = false;  ///< else one that the extent names
  std::size_t run = 0;
};

/// The last `most`, in the order of time, each once: those that are named go before computed ones.
void keepLast(std::size_t most, std::vector<Found>& found) {
  std::ranges::sort(found, {}, [](const Found& f) { return std::tuple(f.time_s, f.isComputed, f.run); });
  const auto [first, last] = std::ranges::unique(found, {}, &Found::time_s);
  found.erase(first, last);
  if (found.size() > most) found.erase(found.begin(), found.end() - static_cast<std::ptrdiff_t>(most));
}

/// Those of a run later than `after_s`, from its end back; at most `most`.
void addSteps(const Run& run, std::size_t place, double after_s, std::size_t most, std::vector<Found>& found) {
  std::size_t count = 0;
  for (double index = run.lastIndex(); index >= 0.0 && count < most; index -= 1.0) {
    const double time_s = run.at(index);
    if (time_s > run.end_s) continue;
    if (time_s <= after_s) return;
    found.push_back({time_s, index > 0.0, place});
    ++count;
  }
}

std::string nameOf(const Found& found, const Run& run) {
  if (!found.isComputed) return found.time_s == secondsOfTime(run.span->start) ? run.span->start : run.span->end;
  const bool isDay = run.span->start.find('T') == std::string::npos && std::fmod(run.period->seconds, 86400.0) == 0.0;
  return isoTime(found.time_s).substr(0, isDay ? 10 : 20);
}

}  // namespace

std::vector<TimeStep> timeSteps(std::span<const TimeSpan> extent, std::size_t most) {
  constexpr std::size_t kMostRounds = 16;
  const std::vector<Run> runs = runsOf(extent);
  std::vector<std::size_t> order(runs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t i) { return runs[i].end_s; });
  std::vector<Found> found;
  double after_s = -std::numeric_limits<double>::infinity();  // as many are known that are later
  std::size_t rounds = 0;
  for (const std::size_t i : order) {
    if (runs[i].end_s <= after_s || rounds == kMostRounds) break;
    addSteps(runs[i], i, after_s, most, found);
    if (found.size() < 2 * most) continue;
    keepLast(most, found);
    if (found.size() == most && most > 0) after_s = found.front().time_s;
    ++rounds;
  }
  keepLast(most, found);
  std::vector<TimeStep> steps;
  for (const Found& one : found)
    steps.push_back({.time_s = one.time_s, .name = nameOf(one, runs[one.run])});
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
  constexpr std::size_t kMostSpans = 100'000;
  std::vector<TimeSpan> extent;
  std::size_t commas = 0;
  for (std::size_t at = text.size(); at > 0; --at) {
    if (text[at - 1] != ',' || ++commas < kMostSpans) continue;
    text = text.substr(at);
    break;
  }
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
