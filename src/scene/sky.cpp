#include "scene/sky.h"

#include "geo/angle.h"
#include "geo/body_turn.h"
#include "geo/sun.h"
#include "scene/atmosphere.h"

namespace tellurion::scene {

SkyPlaces skyPlacesAt(const geo::Body& body, std::optional<double> time_s) {
  SkyPlaces out;
  if (!time_s) return out;
  if (const auto turn = geo::bodyFromCelestial(body, *time_s)) out.bodyFromCelestial = *turn;
  if (body.name == "earth") out.moon_m = geo::moonOverEarth_m(*time_s);
  out.toSun = geo::directionToSun(body, *time_s);
  return out;
}

Sky skyFor(const SkySettings& settings, const SkyPlaces& places, const geo::Body& body, bool sunStands) {
  if (!settings.enabled) return {};
  Sky out{.stars = settings.stars,
          .brightness_stops = settings.brightness_stops,
          .bodyFromCelestial = places.bodyFromCelestial,
          .sunRadius_radians = 0.0,
          .moon_m = {},
          .toSun = places.toSun};
  if (!settings.discs) return out;
  out.moon_m = places.moon_m;
  const Atmosphere own = atmosphereByName(body.name).value_or(Atmosphere{});
  if (sunStands) out.sunRadius_radians = geo::Angle::degrees(own.sunRadius_degrees).radians();
  return out;
}

}  // namespace tellurion::scene
