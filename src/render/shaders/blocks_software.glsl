// blocks.glsl for Mesa's software renderers, which shade one triangle at a time, so a tile's own numbers are the same for
// all that is shaded together; they take both sides of every branch, and would read all blocks there.
layout(binding = 3) uniform sampler2DArray reliefs[kMostReliefBlocks];
layout(binding = 6) uniform sampler2DArray blocks[kMostBlocks];

vec4 texelOf(int block, vec3 place, vec2 alongX, vec2 alongY) { return texture(blocks[block], place); }

vec3 reliefTexel(int number, vec2 place) {
  return texture(reliefs[number / kPlacesABlock], vec3(place, float(number % kPlacesABlock))).xyz;
}
