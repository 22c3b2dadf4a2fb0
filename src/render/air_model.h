#pragma once

#include "geo/ellipsoid.h"
#include "geo/vector.h"
#include "scene/atmosphere.h"

namespace tellurion::render {

namespace air_shading {
using glm::vec4;
#include "render/shaders/air_structs.glsl"
}  // namespace air_shading

geo::Vec3f bandsOf(const scene::ThreeBands& values);

/// An atmosphere as the shaders have it, on a sphere of this radius (> top_m).
air_shading::AirModel airModelOf(const scene::Atmosphere& atmosphere, double radius_m);

/// Body coordinates times this make the ellipsoid a sphere of its mean radius. Straight lines stay straight, so the
/// horizon stays where it is, and so does the line between day and night, with the sun's direction made longer and
/// shorter likewise. Heights and ways come out wrong by the flattening at most.
geo::Vec3 airFromBody(const geo::Ellipsoid& ellipsoid);

/// Where the eye is, in scaled coordinates, in double precision.
struct EyeInAir {
  geo::Vec3 up{0.0};     ///< unit vector from the centre
  geo::Vec3 toSun{0.0};  ///< unit vector
  double height_m = 0.0;
  double sunCosine = 0.0;  ///< of the angle from the zenith to the sun
};
EyeInAir eyeInAir(const geo::Ellipsoid& ellipsoid, const geo::BodyPosition& eye, const geo::Vec3& toSun_body);

/// The air as that eye sees it, but for AirView::up.w and toSun.w. An eye below the air's bottom is taken for one on
/// it.
air_shading::AirView airViewOf(const scene::Atmosphere& atmosphere, const geo::Ellipsoid& ellipsoid,
                               const EyeInAir& eye);

}  // namespace tellurion::render
