// The discs of the sun and the Moon, a square each.
uniform vec4 discs[2];  // direction, body axes; w: radius in radians
uniform float pixel;    // radians
uniform int first;      // of discs: what is drawn begins there

flat out int which;
flat out vec3 away_view;  // from the eye to its middle
out vec3 reaches;
out vec2 fromMiddle;  // 1 at its rim
out vec3 sideways_view;
out vec3 upwards_view;

void main() {
  which = first + gl_InstanceID;
  vec4 disc = discs[which];
  reaches = airBetween(disc.xyz).reaches;
  away_view = mat3(viewFromBody) * disc.xyz;
  sideways_view = normalize(cross(away_view, abs(away_view.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  upwards_view = cross(sideways_view, away_view);
  fromMiddle = (1.0 + pixel / disc.w) * vec2(gl_VertexID % 2 == 0 ? -1.0 : 1.0, gl_VertexID / 2 == 0 ? -1.0 : 1.0);
  vec3 corner_view = away_view + disc.w * (fromMiddle.x * sideways_view + fromMiddle.y * upwards_view);
  gl_Position = vec4(onPicture(corner_view), 0.0, -corner_view.z);
}
