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
  for (int i = 0; i < textureLayers.z; ++i) {
    int record = 4 * (textureLayers.x + i);
    vec4 window = texelFetch(pictures, record);
    vec4 look = texelFetch(pictures, record + 1);  // layer, block, opacity, strength of night lights
    vec4 blend = texelFetch(pictures, record + 2);
    vec4 texel = look.y < 0.0 ? window
                              : texelOf(int(look.y), vec3(window.xy + window.zw * place, look.x), window.zw * alongX,
                                        window.zw * alongY);
#ifdef ADJUSTED
    vec4 adjustment = texelFetch(pictures, record + 3);
    texel.rgb = texel.a * adjusted(texel.rgb / max(texel.a, 1e-4), blend.w, adjustment);
#endif
    ground = blended(ground, texel, blend.xyz, look.z);
    lamps = max(lamps, texel.a * look.w);
  }
  colour = vec4(shadedGround(ground, lamps), 1.0);
}
