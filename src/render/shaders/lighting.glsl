// Linear light of lamps of this strength, 0..1, where the sun stands at this sine over the horizon.
vec3 lampLight(float strength, float sunHeight) {
  float night = 1.0 - smoothstep(kNightLightsFull, kNightLightsOut, sunHeight);
  return vec3(kNightLightRed, kNightLightGreen, kNightLightBlue) * (strength * night);
}

// What rough water sends to the eye of the sun's light, as a share of what white ground does that faces the sun: facets
// whose slopes are spread as Cox and Munk (1954) measured, for a wind of 5 m/s, each a mirror (Fresnel's law as Schlick
// has it).
float sunInWater(vec3 toEye, vec3 up, vec3 toSun) {
  // The facet's normal is that of toEye + toSun, twice as long as the cosine of half the angle between them.
  float eyeHeight = dot(toEye, up);
  float length2 = max(2.0 + 2.0 * dot(toEye, toSun), 1e-12);
  float length_ = sqrt(length2);
  float upright = max(eyeHeight + dot(toSun, up), 1e-3 * length_);
  float perCosine2 = length2 / (upright * upright);
  float missing = max(1.0 - 0.5 * length_, 0.0);
  float missing2 = missing * missing;
  float reflects = kWaterReflects + (1.0 - kWaterReflects) * missing2 * missing2 * missing;
  float facets = exp((1.0 - perCosine2) / kWaterSlopes) / (4.0 * kWaterSlopes);
  return reflects * facets * perCosine2 * perCosine2 / max(eyeHeight, kWaterGrazing);
}

// Linear light that leaves the ground towards the eye. Lambert's law with the relief's normal; vectors are in body axes,
// normal_body and toSun_body of unit length. ambient is the share of full light where the sun does not reach,
// mirrored what water makes of the sun (sunInWater), and nightLights the strength of lamps, 0..1.
vec3 litGround(vec3 albedo, float mirrored, float nightLights, vec3 normal_body, vec3 up_body, vec3 toSun_body, float ambient) {
  float sunHeight = dot(up_body, toSun_body);
  float risen = smoothstep(kSunriseBegins, kSunriseEnds, sunHeight);
  float sunlight = max(dot(normal_body, toSun_body), 0.0) * risen;
  return albedo * (ambient + (1.0 - ambient) * sunlight) + mirrored * smoothstep(-kSunRim, kSunRim, sunHeight) + lampLight(nightLights, sunHeight);
}

// The normal of ground whose heights are drawn `exaggeration` times as high: slopes grow with it.
vec3 exaggeratedNormal(vec3 normal, vec3 up, float exaggeration) {
  vec3 upright = up * dot(normal, up);
  return normalize(upright + (normal - upright) * exaggeration);
}

// Relief texels hold 128 + 127 v, so that 128 is exactly no relief.
vec3 reliefFromTexel(vec3 texel) { return (texel * 255.0 - 128.0) / 127.0; }
