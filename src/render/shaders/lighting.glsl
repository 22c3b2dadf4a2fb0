// Linear light of lamps of this strength, 0..1, where the sun stands at this sine over the horizon.
vec3 lampLight(float strength, float sunHeight) {
  float night = 1.0 - smoothstep(kNightLightsFull, kNightLightsOut, sunHeight);
  return vec3(kNightLightRed, kNightLightGreen, kNightLightBlue) * (strength * night);
}

// Linear light that leaves the ground towards the eye. Lambert's law with the relief's normal; vectors are in body axes,
// normal_body and toSun_body of unit length. ambient is the share of full light where the sun does not reach, and
// nightLights the strength of lamps, 0..1.
vec3 litGround(vec3 albedo, float nightLights, vec3 normal_body, vec3 up_body, vec3 toSun_body, float ambient) {
  float sunHeight = dot(up_body, toSun_body);
  float sunlight = max(dot(normal_body, toSun_body), 0.0) * smoothstep(kSunriseBegins, kSunriseEnds, sunHeight);
  return albedo * (ambient + (1.0 - ambient) * sunlight) + lampLight(nightLights, sunHeight);
}

// The normal of ground whose heights are drawn `exaggeration` times as high: slopes grow with it.
vec3 exaggeratedNormal(vec3 normal, vec3 up, float exaggeration) {
  vec3 upright = up * dot(normal, up);
  return normalize(upright + (normal - upright) * exaggeration);
}

// Relief texels hold 128 + 127 v, so that 128 is exactly no relief.
vec3 reliefFromTexel(vec3 texel) { return (texel * 255.0 - 128.0) / 127.0; }
