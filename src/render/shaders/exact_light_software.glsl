// The light that a sampler's texel means, for Mesa's software renderers: they decode sRGB by a cubic, and by a straight line
// up to 15 of 255, which is off by up to 2.5% of dark light and 0.0012 of bright. Contrast would make whole steps of that.
// Turned back into the sRGB number, and decoded as it is.
vec3 exactLight(vec3 light) {
  const vec4 cubic = vec4(0.0023, 0.0030, 0.6935, 0.3012);
  const float lineEnds = 15.5 / 255.0 / 12.6;
  vec3 number = sqrt(light);
  for (int i = 0; i < 2; ++i) {  // Newton's method: within 1e-5
    vec3 over = cubic.x + number * (cubic.y + number * (cubic.z + number * cubic.w)) - light;
    number -= over / (cubic.y + number * (2.0 * cubic.z + number * (3.0 * cubic.w)));
  }
  number = mix(number, light * 12.6, lessThan(light, vec3(lineEnds)));
  vec3 curve = pow((max(number, 0.0) + 0.055) / 1.055, vec3(2.4));
  return mix(curve, number / 12.92, lessThan(number, vec3(0.04045)));
}
