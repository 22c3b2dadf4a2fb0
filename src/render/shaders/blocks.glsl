// A texel of a block of pictures. A block differs from tile to tile of one draw call, which OpenGL does not allow as the
// index of a sampler; the counter of a loop it does.
layout(binding = 3) uniform sampler2DArray blocks[kMostBlocks];

vec4 texelOf(int block, vec3 place, vec2 alongX, vec2 alongY) {
  vec4 texel = vec4(0.0);
  for (int i = 0; i < kMostBlocks; ++i) {
    if (i == block) texel = textureGrad(blocks[i], place, alongX, alongY);
  }
  return texel;
}
