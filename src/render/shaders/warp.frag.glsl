// The pixels of a piece of a bent picture that lie on one face of the cube around the eye.
layout(binding = 0) uniform sampler2D face;  // sRGB numbers, not decoded

uniform vec4 shape;           // as warpDirection has it
uniform vec3 piece;           // left and upper end in the whole picture, height
uniform mat3 faceFromWarp;
uniform vec3 faceWindow;      // texels of the window's left and upper end on the face, texels of the face's side

layout(location = 0) out vec4 colour;

const float kOverEdge = 1e-4;  // a pixel on the edge of two faces may be drawn by both, but not by none

vec3 lightAt(ivec2 texel) {
  ivec2 size = textureSize(face, 0);
  ivec2 within = clamp(texel, ivec2(0), size - 1);
  vec3 number = texelFetch(face, ivec2(within.x, size.y - 1 - within.y), 0).rgb;
  return mix(pow((number + 0.055) / 1.055, vec3(2.4)), number / 12.92, lessThan(number, vec3(0.04045)));
}

void main() {
  vec2 place = vec2(piece.x + gl_FragCoord.x, piece.y + piece.z - gl_FragCoord.y);
  vec4 direction_warp = warpDirection(shape, place);
  vec3 direction_face = faceFromWarp * direction_warp.xyz;
  if (direction_warp.w < 0.5) discard;
  if (max(abs(direction_face.x), abs(direction_face.y)) > -direction_face.z * (1.0 + kOverEdge)) discard;
  vec2 onFace = direction_face.xy / -direction_face.z;
  vec2 texel = 0.5 * faceWindow.z * vec2(onFace.x + 1.0, 1.0 - onFace.y) - faceWindow.xy - 0.5;
  ivec2 first = ivec2(floor(texel));
  vec2 share = texel - floor(texel);
  vec3 above = mix(lightAt(first), lightAt(first + ivec2(1, 0)), share.x);
  vec3 below = mix(lightAt(first + ivec2(0, 1)), lightAt(first + ivec2(1, 1)), share.x);
  colour = vec4(mix(above, below, share.y), 1.0);
}
