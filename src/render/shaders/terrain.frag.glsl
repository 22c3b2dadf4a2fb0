layout(binding = 0) uniform sampler2DArray colours;  // sRGB, decoded by the sampler; alpha is the strength of night lights
layout(binding = 1) uniform sampler2DArray reliefs;

in vec4 textureCoordinates;
in vec3 upInterpolated_body;
flat in vec4 plainColour;
flat in ivec2 textureLayers;

layout(location = 0) out vec4 colour;

void main() {
  vec4 texel = texture(colours, vec3(textureCoordinates.xy, float(textureLayers.x)));
  vec3 albedo = texel.rgb * plainColour.a + plainColour.rgb;
  vec3 relief = reliefFromTexel(texture(reliefs, vec3(textureCoordinates.zw, float(textureLayers.y))).xyz);
  vec3 up_body = normalize(upInterpolated_body);
  vec3 normal_body = exaggeratedNormal(up_body + relief * float(textureLayers.y >= 0), up_body, switches.y + 1.0);
  vec3 lit = litGround(albedo, texel.a * plainColour.a, normal_body, up_body, toSun_body.xyz, toSun_body.w);
  colour = vec4(mix(albedo, lit, switches.x), 1.0);
}
