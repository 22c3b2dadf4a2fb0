// Light of the air where no ground is behind it, the sun's disc, and what is left of the background.
in vec3 direction_air;

uniform vec3 background;  // linear

layout(location = 0) out vec4 colour;

// The disc is a thousand times too bright for any picture: it keeps its colour at what still looks like the sun.
vec3 sunDisc(vec3 direction, vec3 reaches) {
  float angle = length(direction - vec3(airView.toSun));
  float radius = air.aerosolExtinction.w;
  float soft = 0.5 * airView.toSun.w;
  float covers = 1.0 - smoothstep(radius - soft, radius + soft, angle);
  return reaches * (covers * min(1.0 / (radius * radius), kSunDisc / max(max(max(reaches.r, reaches.g), reaches.b), 1e-9)));
}

void main() {
  vec3 direction = normalize(direction_air);
  AirRay ray = airRay(airView, direction, true);
  vec3 place = airTablePlace(ray, 1.0);
  vec3 reaches = exp(-texture(airDepth, place).rgb);
  vec3 light = texture(airLight, place).rgb;
  float exposure = airView.up.w;
  vec3 sun = sunDisc(direction, reaches) / max(exposure, 1.0);
  colour = vec4(exposed((light + sun) * exposure) + background * reaches, 1.0);
}
