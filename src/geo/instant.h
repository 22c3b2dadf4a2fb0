#pragma once

#include <optional>

namespace tellurion::geo {

/// A Julian date in two parts, as ERFA wants it for its precision.
struct JulianDate {
  double day = 0.0;
  double rest = 0.0;
};

/// A moment in the time scales that the motions in the sky are told in.
struct Instant {
  JulianDate ut1;  ///< UTC is taken for it: they differ by less than 0.9 s
  JulianDate tt;   ///< also taken for TDB: they differ by less than 2 ms

  double daysSinceJ2000() const;
};

/// utc_s: seconds since 1970-01-01T00:00:00 UTC, leap seconds not counted. Nothing for a time that is not finite, and
/// outside the years 1000 to 3000, where the models are not meant to hold.
std::optional<Instant> instantAt(double utc_s);

}  // namespace tellurion::geo
