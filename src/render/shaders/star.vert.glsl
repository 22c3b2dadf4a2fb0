// Stars: each a small square of the sky, a point spread by as many pixels as its brightness takes.
layout(location = 0) in vec4 star;  // direction, celestial axes; w: spread (standard deviation) in pixels
layout(location = 1) in vec3 starLight;

uniform mat3 bodyFromCelestial;
uniform float pixel;  // radians
uniform vec4 moon;    // direction, body axes; w: cosine of its radius, more than 1 without

out vec3 light;
out vec2 fromStar;  // in spreads

const float kReach = 3.0;
// Eyes and films lose stars where the air before them has this light.
const float kGlare = 0.01;
const float kFaintest = 1.0 / 4096.0;

void main() {
  vec3 direction_body = bodyFromCelestial * star.xyz;
  Between between = airBetween(direction_body);
  float dimmed = between.glare / kGlare;
  light = starLight * between.reaches / (1.0 + dimmed * dimmed);
  fromStar = kReach * vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID / 2 == 0 ? -1.0 : 1.0);
  vec3 direction_view = mat3(viewFromBody) * direction_body;
  vec3 sideways = normalize(cross(direction_view, abs(direction_view.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  vec3 corner_view = direction_view + pixel * star.w * (fromStar.x * sideways + fromStar.y * cross(sideways, direction_view));
  gl_Position = vec4(onPicture(corner_view), 0.0, -corner_view.z);
  bool isSeen = max(max(light.r, light.g), light.b) > kFaintest && dot(direction_body, moon.xyz) < moon.w;
  if (!isSeen) gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
}
