#include "geo/sun.h"

#include <erfa.h>
#include <erfam.h>

#include "geo/body_turn.h"
#include "geo/instant.h"

namespace tellurion::geo {
namespace {

constexpr double kSpeedOfLight_auPerDay = ERFA_DC;

/// Place and motion of a body as the sun sees it, equator and equinox of J2000, in astronomical units and days.
struct Orbit {
  Vec3 place{0.0};
  Vec3 speed{0.0};
};

Orbit orbitOf(const double pv[2][3]) {
  return {{pv[0][0], pv[0][1], pv[0][2]}, {pv[1][0], pv[1][1], pv[1][2]}};
}

Orbit earthAt(const Instant& at) {
  double heliocentric[2][3], barycentric[2][3];
  eraEpv00(at.tt.day, at.tt.rest, heliocentric, barycentric);
  return orbitOf(heliocentric);
}

Orbit moonAt(const Instant& at) {
  double geocentric[2][3];
  eraMoon98(at.tt.day, at.tt.rest, geocentric);
  const Orbit earth = earthAt(at), moon = orbitOf(geocentric);
  return {earth.place + moon.place, earth.speed + moon.speed};
}

Orbit marsAt(const Instant& at) {
  constexpr int kMars = 4;
  double heliocentric[2][3];
  eraPlan94(at.tt.day, at.tt.rest, kMars, heliocentric);
  return orbitOf(heliocentric);
}

/// Aberration to the first order in v/c; the second is below 0.001 arc seconds.
Vec3 apparentSun(const Orbit& body) {
  return normalize(normalize(-body.place) + body.speed / kSpeedOfLight_auPerDay);
}

std::optional<Orbit> orbitOf(const Body& body, const Instant& at) {
  if (body.name == "earth") return earthAt(at);
  if (body.name == "mars") return marsAt(at);
  if (body.name == "moon") return moonAt(at);
  return std::nullopt;
}

}  // namespace

std::optional<Vec3> directionToSun(const Body& body, double utc_s) {
  const auto at = instantAt(utc_s);
  if (!at) return std::nullopt;
  const auto orbit = orbitOf(body, *at);
  const auto turn = bodyFromCelestial(body, *at);
  if (!orbit || !turn) return std::nullopt;
  return *turn * apparentSun(*orbit);
}

std::optional<Vec3> moonOverEarth_m(double utc_s) {
  const auto at = instantAt(utc_s);
  if (!at) return std::nullopt;
  double geocentric[2][3];
  eraMoon98(at->tt.day, at->tt.rest, geocentric);
  const auto turn = bodyFromCelestial(earth(), *at);
  return *turn * orbitOf(geocentric).place * ERFA_DAU;
}

}  // namespace tellurion::geo
