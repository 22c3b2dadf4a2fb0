// A tile of one opaque picture, or of none.
layout(binding = 0) uniform sampler2DArray colours;  // sRGB, decoded by the sampler

flat in vec4 plainColour;

void main() {
  vec4 texel = texture(colours, vec3(textureCoordinates.xy, float(textureLayers.x)));
  colour = vec4(shadedGround(texel.rgb * plainColour.a + plainColour.rgb, 0.0), 1.0);
}
