// A texel of a block of pictures or reliefs. A block differs from tile to tile of one draw call, which OpenGL does not
// allow as the index of a sampler; the counter of a loop it does.
layout(binding = 3) uniform sampler2DArray reliefs[kMostReliefBlocks];
layout(binding = 6) uniform sampler2DArray blocks[kMostBlocks];

vec4 texelOf(int block, vec3 place, vec2 alongX, vec2 alongY) {
  vec4 texel = vec4(0.0);
  for (int i = 0; i < kMostBlocks; ++i) {
    if (i == block) texel = textureGrad(blocks[i], place, alongX, alongY);
  }
  return texel;
}

vec3 reliefTexel(int number, vec2 place) {
  vec2 alongX = dFdx(place);
  vec2 alongY = dFdy(place);
  vec3 texel = vec3(0.0);
  for (int i = 0; i < kMostReliefBlocks; ++i) {
    if (i == number / kPlacesABlock)
      texel = textureGrad(reliefs[i], vec3(place, float(number % kPlacesABlock)), alongX, alongY).xyz;
  }
  return texel;
}
