// A tile over its own picture, or the sides of its triangles. Behind terrain.vert.glsl, whose records are others here
// (debug_pass.cpp): the window is the whole tile, `plain` the fill, and the layers hold the border.
in vec4 textureCoordinates;  // s, t
flat in vec4 plainColour;    // linear light and strength
flat in ivec4 textureLayers;  // x: the border's linear light and strength, 8 bits each; strength 0: none

layout(location = 0) out vec4 colour;

const float kBorderWidth = 1.5;  // pixels, on each side of an edge

void main() {
  vec2 place = textureCoordinates.xy;
  vec4 border = unpackUnorm4x8(uint(textureLayers.x));
  vec2 pixelsToEdge = min(place, 1.0 - place) / max(fwidth(place), vec2(1e-9));
  bool atEdge = min(pixelsToEdge.x, pixelsToEdge.y) < kBorderWidth;
  colour = atEdge && border.a > 0.0 ? border : plainColour;
}
