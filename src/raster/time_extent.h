#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tellurion::raster {

/// Times that a layer has: an instant, or instants every `period` from start to end. As ISO 8601 text.
struct TimeSpan {
  std::string start;
  std::string end;     ///< empty: an instant
  std::string period;  ///< "P1D", "PT5M"; empty: not stated, any time between
};

/// "2000-01-01,2001-01-01/2002-01-01/P1M": instants and spans, parted by commas. Empty parts are passed over; of more
/// than 100,000 parts the last are read.
std::vector<TimeSpan> parseTimeExtent(std::string_view text);

/// Seconds since 1970-01-01T00:00:00Z of an ISO 8601 instant of any precision, from a year to fractions of a second:
/// its beginning. Nothing: it is none ("current", a climatology).
std::optional<double> secondsOfTime(std::string_view iso);

/// Whether one of the spans has the instant, as far as can be told: an instant that it names, or a time within a span.
/// Both compared as instants, so "2000" is 2000-01-01T00:00Z. True for a time that cannot be read, too.
bool offersTime(std::span<const TimeSpan> extent, std::string_view iso);

/// The last time of all; empty where there is none.
std::string lastTime(std::span<const TimeSpan> extent);

/// An instant, and how the layer that has it names it.
struct TimeStep {
  double time_s = 0.0;  ///< seconds since 1970-01-01T00:00:00Z
  std::string name;     ///< as it stands in the extent, else ISO 8601
};

/// All instants, those of spans with a period spelled out (months and years by the calendar, from the start), in the
/// order of time, each once: the last `most` of them. Of spans without a period their start and end; steps closer than
/// a second count as a second apart. What cannot be read is passed over. At most 32 times `most` steps and the number
/// of spans are computed: where many long spans overlap, those that end first may be left out.
std::vector<TimeStep> timeSteps(std::span<const TimeSpan> extent, std::size_t most);

/// "2004-01-31T12:00:00Z" of seconds since 1970-01-01T00:00:00Z, rounded down to whole ones. Of years from 0 to 9999.
std::string isoTime(double time_s);

/// For people: "1999-01-01 to 2000-08-22 every P1D", "12 times, 2000-01-01 to 2000-12-01"; empty where there is none.
std::string describeTimes(std::span<const TimeSpan> extent);

}  // namespace tellurion::raster
