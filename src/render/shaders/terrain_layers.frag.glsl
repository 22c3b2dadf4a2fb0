// A tile of several pictures, bottom first, blended in linear light (docs/rendering.md). Its texture coordinates are its
// own (s, t); textureLayers.x is the first of its records, z how many it has.
layout(binding = 2) uniform samplerBuffer pictures;  // struct PictureRecord of layer_records.h

flat in vec4 plainColour;

void main() {
  vec2 place = textureCoordinates.xy;
  vec2 alongX = dFdx(place);
  vec2 alongY = dFdy(place);
  vec3 ground = plainColour.rgb;
  float lamps = 0.0;
  float water = 0.0;
  // Asked at the end: Mesa's software renderers go once more through a loop that asks at its beginning.
  int i = 0;
  if (textureLayers.z > 0) do {
    int record = 3 * (textureLayers.x + i);
    vec4 window = texelFetch(pictures, record);
    vec4 look = texelFetch(pictures, record + 1);  // place, opacity, strength of night lights or, less than 0, of water, blend mode
    int at = int(look.x);
    vec4 texel = at < 0 ? window
                        : texelOf(at / kPlacesABlock, vec3(window.xy + window.zw * place, float(at % kPlacesABlock)),
                                  window.zw * alongX, window.zw * alongY);
#ifdef ADJUSTED
    vec3 light = at < 0 ? texel.rgb : exactLight(texel.rgb);
    texel.rgb = texel.a * adjusted(light / max(texel.a, 1e-4), texelFetch(pictures, record + 2));
#endif
    ground = blended(ground, texel, int(look.w), look.y);
    lamps = max(lamps, texel.a * look.z);
    water = max(water, -texel.a * look.z);
  } while (++i < textureLayers.z);
  colour = vec4(shadedGround(ground, lamps, water), 1.0);
}
