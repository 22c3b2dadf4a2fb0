// One triangle over the whole picture, at an infinite distance: it shows where nothing else was drawn.
out vec3 direction_air;

void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
  vec3 direction_view = vec3(corner / projection.xy, -1.0);
  direction_air = airView.scale.xyz * (transpose(mat3(viewFromBody)) * direction_view);
}
