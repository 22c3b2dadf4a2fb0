// A tile of one opaque picture, or of none; with NIGHT, and of one of night lights.
layout(binding = 0) uniform sampler2DArray colours;  // sRGB, decoded by the sampler

flat in vec4 plainColour;

#ifdef NIGHT
layout(binding = 1) uniform sampler2DArray nightLights;
in vec2 lampsPlace;
float lampsHere() {
  return texture(nightLights, vec3(lampsPlace, float(textureLayers.z))).a * intBitsToFloat(textureLayers.w);
}
#else
float lampsHere() { return 0.0; }
#endif

void main() {
  vec4 texel = texture(colours, vec3(textureCoordinates.xy, float(textureLayers.x)));
  colour = vec4(shadedGround(texel.rgb * plainColour.a + plainColour.rgb, lampsHere()), 1.0);
}
