// How layers are laid over each other: linear light, texels multiplied with their coverage.

float luminance(vec3 light) { return dot(light, vec3(0.2126, 0.7152, 0.0722)); }

// What a picture makes of the ground under it. With its colour C = texel.rgb / texel.a and the ground G it is
// x C + y G + z C G, at most 1, where it is covered; kOverlay turns from 2 C G into 1 - 2 (1 - C) (1 - G) at G = 1/2.
vec3 blended(vec3 ground, vec4 texel, int mode, float opacity) {
  float x = mode == kMultiply ? 0.0 : 1.0;
  float y = mode == kScreen || mode == kAdd ? 1.0 : 0.0;
  float z = mode == kMultiply ? 1.0 : mode == kScreen ? -1.0 : 0.0;
  vec3 both = x * texel.rgb + (y * texel.a) * ground + z * texel.rgb * ground;
  if (mode == kOverlay) {
    vec3 lighter = texel.a - 2.0 * (texel.a - texel.rgb) * (1.0 - ground);
    both = mix(2.0 * texel.rgb * ground, lighter, step(0.5, ground));
  }
  return ground * (1.0 - texel.a * opacity) + min(both, vec3(texel.a)) * opacity;
}

// adjustment: brightness, contrast, saturation, 1 / gamma. Each does nothing at 1.
vec3 adjusted(vec3 light, vec4 adjustment) {
  vec3 bright = max(kMiddleGrey + (light * adjustment.x - kMiddleGrey) * adjustment.y, 0.0);
  vec3 saturated = max(mix(vec3(luminance(bright)), bright, adjustment.z), 0.0);
  return pow(min(saturated, 1.0), vec3(adjustment.w));
}
