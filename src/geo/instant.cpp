#include "geo/instant.h"

#include <erfa.h>
#include <erfam.h>

namespace tellurion::geo {
namespace {

constexpr double kUnixEpoch_jd = 2440587.5;
constexpr double kDay_s = 86400.0;
constexpr double kYear_s = 365.25 * kDay_s;
constexpr double kFirst_s = (1000.0 - 1970.0) * kYear_s;
constexpr double kLast_s = (3000.0 - 1970.0) * kYear_s;

}  // namespace

double Instant::daysSinceJ2000() const {
  return (tt.day - ERFA_DJ00) + tt.rest;
}

std::optional<Instant> instantAt(double utc_s) {
  if (!(utc_s >= kFirst_s && utc_s <= kLast_s)) return std::nullopt;
  Instant out;
  const JulianDate utc{kUnixEpoch_jd, utc_s / kDay_s};
  out.ut1 = utc;
  JulianDate tai;
  // Their answers say no more than that a date is before leap seconds were or after the last one known.
  eraUtctai(utc.day, utc.rest, &tai.day, &tai.rest);
  eraTaitt(tai.day, tai.rest, &out.tt.day, &out.tt.rest);
  return out;
}

}  // namespace tellurion::geo
