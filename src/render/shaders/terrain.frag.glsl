// A tile of one opaque picture, or of none; with SECOND, and of one of night lights or of water.
layout(binding = 0) uniform sampler2DArray colours;  // sRGB, decoded by the sampler

flat in vec4 plainColour;

#ifdef SECOND
layout(binding = 1) uniform sampler2DArray second;
in vec2 secondPlace;
#endif

void main() {
  vec4 texel = texture(colours, vec3(textureCoordinates.xy, float(textureLayers.x)));
  vec3 ground = texel.rgb * plainColour.a + plainColour.rgb;
#ifdef SECOND
  float strength = texture(second, vec3(secondPlace, float(textureLayers.z))).a * intBitsToFloat(textureLayers.w);
  colour = vec4(shadedGround(ground, max(strength, 0.0), max(-strength, 0.0)), 1.0);
#else
  colour = vec4(shadedGround(ground, 0.0, 0.0), 1.0);
#endif
}
