flat in int which;
flat in vec3 away_view;
in vec3 reaches;
in vec2 fromMiddle;
in vec3 sideways_view;
in vec3 upwards_view;

uniform vec4 discs[2];
uniform float pixel;
uniform vec3 sunOfMoon_body;

layout(location = 0) out vec4 colour;

const float kMoonAlbedo = 0.13;  // normal albedo: what a full Moon's middle sends back

void main() {
  float soft = 0.5 * pixel / discs[which].w;
  float from2 = dot(fromMiddle, fromMiddle);
  float covers = 1.0 - smoothstep(1.0 - soft, 1.0 + soft, sqrt(from2));
  if (which == 0) {
    vec3 direction_view = away_view + discs[0].w * (fromMiddle.x * sideways_view + fromMiddle.y * upwards_view);
    float fromMoon = length(normalize(direction_view) - mat3(viewFromBody) * discs[1].xyz);
    covers *= smoothstep(discs[1].w - 0.5 * pixel, discs[1].w + 0.5 * pixel, fromMoon);  // an eclipse
    colour = vec4(min(reaches * kSunDisc, 1.0) * covers, 0.0);
    return;
  }
  // Dust scatters as Lommel and Seeliger say: a full Moon has no shade towards its rim.
  float towards = sqrt(max(1.0 - from2, 0.0));
  vec3 normal_view = fromMiddle.x * sideways_view + fromMiddle.y * upwards_view - towards * away_view;
  float sun = max(dot(normal_view, mat3(viewFromBody) * sunOfMoon_body), 0.0);
  float light = kMoonAlbedo * 2.0 * sun / max(sun + towards, 1e-3);
  colour = vec4(asSeen(light * reaches) * covers, 0.0);
}
