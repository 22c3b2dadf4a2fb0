// Where a place of a bent picture lies, in what GLSL and C++ have in common: face_windows.cpp reads this same file.

// shape: width, height, radians a pixel, 1 equirectangular or 0 a fisheye. place: pixels from the upper left corner. The
// direction is told in axes with x right, y up, the picture's middle along -z; w: 1, or 0 beyond the circle of a fisheye.
vec4 warpDirection(vec4 shape, vec2 place) {
  vec2 fromMiddle = vec2(place.x - 0.5f * shape.x, 0.5f * shape.y - place.y);
  if (shape.w > 0.5f) {
    vec2 angle = fromMiddle * shape.z;
    return vec4(cos(angle.y) * sin(angle.x), sin(angle.y), -cos(angle.y) * cos(angle.x), 1.0f);
  }
  float radius = length(fromMiddle);
  float angle = radius * shape.z;
  vec2 across = fromMiddle * (sin(angle) / max(radius, 1e-6f));
  return vec4(across.x, across.y, -cos(angle), radius <= 0.5f * min(shape.x, shape.y) ? 1.0f : 0.0f);
}
