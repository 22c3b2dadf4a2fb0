#pragma once

#include <memory>
#include <optional>

#include "geo/body.h"
#include "geo/vector.h"
#include "scene/star_catalogue.h"

namespace tellurion::scene {

/// Whether, and how, what stands behind the air is drawn.
struct SkySettings {
  bool enabled = false;
  std::shared_ptr<const StarCatalogue> stars;  ///< null: none
  double brightness_stops = 0.0;               ///< stars are drawn 2^this times as bright
  bool discs = true;                           ///< the sun's and, over the Earth, the Moon's
};

/// Where it stands at a time.
struct SkyPlaces {
  geo::Mat3 bodyFromCelestial{1.0};  ///< a rotation (geo/body_turn.h)
  std::optional<geo::Vec3> moon_m;   ///< from the body's centre, body axes
  std::optional<geo::Vec3> toSun;    ///< unit, body axes: what lights the Moon, wherever the scene has its sun
};

/// time_s: seconds since 1970-01-01T00:00:00Z. Without a time, outside the years that are known, and over a body whose
/// motion is not known, the celestial axes are the body's and there is no Moon.
SkyPlaces skyPlacesAt(const geo::Body& body, std::optional<double> time_s);

/// What of it is drawn.
struct Sky {
  std::shared_ptr<const StarCatalogue> stars;  ///< null: none
  double brightness_stops = 0.0;
  geo::Mat3 bodyFromCelestial{1.0};
  double sunRadius_radians = 0.0;   ///< as the eye sees it, towards Light::toSun_body; 0: not drawn
  std::optional<geo::Vec3> moon_m;  ///< from the body's centre, body axes; nothing: not drawn
  std::optional<geo::Vec3> toSun;   ///< what lights the Moon; nothing: the light's

  bool isEmpty() const { return !stars && sunRadius_radians <= 0.0 && !moon_m; }
};

/// sunStands: it has a place of its own, and does not go with the camera.
Sky skyFor(const SkySettings& settings, const SkyPlaces& places, const geo::Body& body, bool sunStands);

}  // namespace tellurion::scene
