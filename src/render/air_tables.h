#pragma once

#include <vector>

#include "geo/vector.h"
#include "scene/atmosphere.h"

namespace tellurion::render {

/// What the shaders read of an atmosphere, as rgb and an unused number a texel, row 0 first; sizes and places as
/// shaders/air_model.glsl has them.
struct AirTables {
  std::vector<geo::Vec4f> transmittance;  ///< share of light from outside that reaches a height, by its angle
  std::vector<geo::Vec4f> glow;  ///< light of the air from all sides, but for the sun's own, times its illuminance
  std::vector<geo::Vec4f> groundLight;  ///< on level ground at a height: two pictures, of the sun and of the sky
};

/// Of an atmosphere on a sphere of this radius (> top_m). Pure; takes about 0.2 s.
///
/// Sources: transmittance as in Bruneton and Neyret, "Precomputed Atmospheric Scattering" (2008); light that is
/// scattered more than once as in Hillaire, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique"
/// (2020): the second order is integrated, all further ones are a geometric series of it, without direction.
AirTables makeAirTables(const scene::Atmosphere& atmosphere, double radius_m);

/// Light of sun and sky on level ground (its luminance; 1: white ground under the sun outside of all air), where the
/// sun stands at an angle of this cosine from the zenith.
double groundLightAt(const AirTables& tables, const scene::Atmosphere& atmosphere, double radius_m, double height_m,
                     double sunCosine);

}  // namespace tellurion::render
