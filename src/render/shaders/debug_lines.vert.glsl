// Ends of lines, relative to the eye already; _rte and _view as in terrain.vert.glsl.
layout(location = 0) in vec3 position_rte;
layout(location = 1) in vec4 colour;  // linear light and strength

flat out vec4 lineColour;

void main() {
  vec3 position_view = mat3(viewFromBody) * position_rte;
  gl_Position = vec4(onPicture(position_view), projection.z, -position_view.z);
  lineColour = colour;
}
