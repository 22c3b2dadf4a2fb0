// Light of the air where no ground is behind it, the sun's disc, and what is left of the background.
in vec3 skyLight;
in vec3 skyReaches;
in vec2 fromSun;
flat in vec3 moon;  // before the sun: its middle as fromSun has it, its radius; 0: none

uniform vec3 background;  // linear

layout(location = 0) out vec4 colour;

// The disc is a thousand times too bright for any picture: it keeps its colour at what still looks like the sun.
vec3 sunDisc() {
  float soft = 0.5 * airView.toSun.w / air.aerosolExtinction.w;
  float covers = 1.0 - smoothstep(1.0 - soft, 1.0 + soft, length(fromSun));
  covers *= moon.z > 0.0 ? smoothstep(-soft, soft, length(fromSun - moon.xy) - moon.z) : 1.0;
  float most = max(max(skyReaches.r, skyReaches.g), skyReaches.b);
  float full = 1.0 / (air.aerosolExtinction.w * air.aerosolExtinction.w);
  return skyReaches * (covers * min(full, kSunDisc / max(most, 1e-9)));
}

void main() {
  vec3 light = skyLight * airView.up.w + sunDisc();
  colour = vec4(dithered(exposed(light) + background * skyReaches, gl_FragCoord.xy), 1.0);
}
