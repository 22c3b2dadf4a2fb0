// What is the same for a whole frame: filled by renderer.cpp (struct FrameBlock).
layout(std140, binding = 0) uniform FrameBlock {
  mat4 viewFromBody;   // a rotation
  vec4 projection;     // x scale, y scale, near plane in metres
  vec4 eyeRemainder;   // metres from the snapped eye to the eye, body axes; w: the vertex grid in metres
  vec4 toSun_body;     // w: ambient
  vec4 switches;       // x: 1 lit, 0 colours as they are; y: vertical exaggeration less 1
  vec4 offAxis;        // x, y: where the middle of the picture lies, in halves of it from the view axis
};

// Clip coordinates x and y; w is -z.
vec2 onPicture(vec3 position_view) {
  return position_view.xy * projection.xy + position_view.z * offAxis.xy;
}
