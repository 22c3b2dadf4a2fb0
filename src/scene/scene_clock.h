#pragma once

#include <optional>

namespace tellurion::scene {

/// The time that layers with time steps show, and how it runs. All in seconds; times since 1970-01-01T00:00:00Z, leap
/// seconds not counted.
struct SceneClock {
  std::optional<double> start_s;  ///< nothing: it stands, of each layer at the last
  std::optional<double> end_s;    ///< where it stops when it runs
  double rate = 86400.0;          ///< of the scene, a second of the spectator; negative: backwards
  double step_s = 86400.0;        ///< > 0; by which it is set ahead and back by hand
};

/// What it shows after it has run for so many seconds of the spectator; nothing without a start. It does not run over
/// its end, whichever way it runs.
std::optional<double> timeAfter(const SceneClock& clock, double seconds);

/// A time by the calendar, UTC, Gregorian also where it was not in use yet.
struct CalendarTime {
  int year = 1970;
  int day = 1;        ///< of the year, from 1
  double hour = 0.0;  ///< from 0 up to 24
};

/// Of the years 0 to 9999: what lies outside is the first or the last second of these; of NaN the first.
CalendarTime calendarTimeOf(double time_s);
/// And back, to a microsecond. Days and hours beyond their end run on into the next year and day.
double secondsOf(const CalendarTime& time);
/// 365 or 366.
int daysOfYear(int year);

}  // namespace tellurion::scene
