// The air's matter and how rays cross it, in what GLSL and C++ have in common: air_tables.cpp reads this same file. Heights
// are metres above the sphere that the ellipsoid is scaled to.

vec3 bands(vec4 v) {
  return vec3(v.x, v.y, v.z);
}

// Gas and aerosol, 1 at height 0, and ozone, 1 at its middle.
vec3 densitiesAt(AirModel air, float height) {
  float ozone = max(1.0f - abs(height - air.ozone.w) * air.aerosolForward.w, 0.0f);
  return vec3(exp(-height * air.gas.w), exp(-height * air.aerosolScattering.w), ozone);
}

// The mean of a density that falls by e in 1 / perMetre, along a straight way from one height to another that are not
// much more apart than what the way climbs evenly.
float meanDensity(float from, float to, float climb, float perMetre) {
  float falls = climb * perMetre;
  return abs(falls) < 0.05f ? 0.5f * (from + to) : (from - to) / falls;
}

vec3 meanDensities(AirModel air, vec3 from, vec3 to, float climb) {
  return vec3(meanDensity(from.x, to.x, climb, air.gas.w), meanDensity(from.y, to.y, climb, air.aerosolScattering.w),
              0.5f * (from.z + to.z));
}

// What is lost a metre.
vec3 extinction(AirModel air, vec3 densities) {
  return bands(air.gas) * densities.x + bands(air.aerosolExtinction) * densities.y + bands(air.ozone) * densities.z;
}

// Light that a metre of this air throws on: sunlight from an angle of this cosine, and the glow of all other air from all
// sides.
vec3 scattered(AirModel air, vec3 densities, float cosine, vec3 sunlight, vec3 glow) {
  vec3 g = bands(air.aerosolForward);
  vec3 gas = bands(air.gas) * densities.x;
  vec3 aerosol = bands(air.aerosolScattering) * densities.y;
  float gasPhase = 3.0f / 16.0f * (1.0f + cosine * cosine);
  vec3 away = 1.0f + g * g - 2.0f * cosine * g;
  vec3 aerosolPhase = 0.25f * (1.0f - g * g) / (away * sqrt(away));
  return (gas * gasPhase + aerosol * aerosolPhase) * sunlight + (gas + aerosol) * glow;
}

// The share of the sun's disc that the ground below does not hide. cosine: of the angle from the zenith to the sun.
float sunVisible(AirModel air, float height, float cosine) {
  float over = max(height - air.sphere.y, 0.0f);
  float bottom = air.sphere.x + air.sphere.y;
  float horizon = -sqrt(over * (2.0f * bottom + over)) / (bottom + over);
  return smoothstep(-air.aerosolExtinction.w, air.aerosolExtinction.w, cosine - horizon);
}

// Where the middles of the first and the last texel are 0 and 1.
float inTexels(float place, int texels) {
  return (0.5f + clamp(place, 0.0f, 1.0f) * float(texels - 1)) / float(texels);
}

// Of the table of what comes through from the top of the air, as Bruneton and Neyret (2008) lay it out: by the distance
// to the top, between the least and the most that there is from this height without meeting the bottom.
vec2 transmittancePlace(AirModel air, float height, float cosine) {
  float bottom = air.sphere.x + air.sphere.y;
  float depth = air.sphere.z - air.sphere.y;
  float over = clamp(height - air.sphere.y, 0.0f, depth);
  float widest = sqrt(depth * (2.0f * bottom + depth));
  float toHorizon = sqrt(over * (2.0f * bottom + over));
  float room = (depth - over) * (2.0f * bottom + depth + over);
  float along = (bottom + over) * cosine;
  float reach = sqrt(room + along * along);
  float distance = along > 0.0f ? room / (reach + along) : reach - along;
  float least = depth - over;
  float share = (distance - least) / (toHorizon + widest - least);
  return vec2(inTexels(share, kTransmittanceWidth), inTexels(toHorizon / widest, kTransmittanceHeight));
}

// Of the sun's height, finest about the horizon.
float sunPlace(float cosine) {
  return 0.5f + 0.5f * sign(cosine) * sqrt(abs(cosine));
}

vec2 glowPlace(AirModel air, float height, float cosine) {
  float share = (height - air.sphere.y) / (air.sphere.z - air.sphere.y);
  return vec2(inTexels(sunPlace(cosine), kGlowSide), inTexels(sqrt(max(share, 0.0f)), kGlowSide));
}

vec2 groundLightPlace(AirModel air, float height, float cosine) {
  float share = (height - air.sphere.y) / ((air.sphere.z - air.sphere.y) * kGroundLightReach);
  return vec2(inTexels(sunPlace(cosine), kGroundLightWidth), inTexels(share, kGroundLightHeight));
}
