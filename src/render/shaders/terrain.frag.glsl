// A tile of one opaque picture, or of none; with SECOND, and of one of night lights, or of water (MIRROR); with THIRD, of
// both.
layout(binding = 0) uniform sampler2DArray colours;  // sRGB, decoded by the sampler

flat in vec4 plainColour;

#ifdef SECOND
layout(binding = 1) uniform sampler2DArray second;
in vec2 secondPlace;
#endif
#ifdef THIRD
layout(binding = 21) uniform sampler2DArray third;
in vec2 thirdPlace;
#endif

void main() {
  vec4 texel = texture(colours, vec3(textureCoordinates.xy, float(textureLayers.x)));
  vec3 ground = texel.rgb * plainColour.a + plainColour.rgb;
  float lamps = 0.0;
  float water = 0.0;
#ifdef SECOND
  vec2 strengths = unpackHalf2x16(uint(textureLayers.w));
  float strength = texture(second, vec3(secondPlace, float(textureLayers.z & 0xffff))).a * strengths.x;
#ifdef THIRD
  water = texture(third, vec3(thirdPlace, float(textureLayers.z >> 16))).a * strengths.y;
  lamps = strength;
#elif defined(MIRROR)
  water = strength;
#else
  lamps = strength;
#endif
#endif
  colour = vec4(shadedGround(ground, lamps, water), 1.0);
}
