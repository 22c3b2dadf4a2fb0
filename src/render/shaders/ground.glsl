// The end of every shader of the terrain: albedo and the strength of lamps, lit.
in vec4 textureCoordinates;
in vec3 upInterpolated_body;
flat in ivec4 textureLayers;

#ifdef AIR
in vec4 place_air;  // relative to the eye; w: height above the ellipsoid
#endif

layout(location = 0) out vec4 colour;

vec3 shadedGround(vec3 albedo, float lamps) {
  vec3 relief = reliefFromTexel(reliefTexel(max(textureLayers.y, 0), textureCoordinates.zw));
  vec3 up_body = normalize(upInterpolated_body);
  vec3 normal_body = exaggeratedNormal(up_body + relief * float(textureLayers.y >= 0), up_body, switches.y + 1.0);
#ifdef AIR
  vec3 light = litGroundInAir(albedo, place_air.w, normal_body, up_body, toSun_body.xyz);
  return throughAir(light, lampLight(lamps, dot(up_body, toSun_body.xyz)), place_air);
#else
  vec3 lit = litGround(albedo, lamps, normal_body, up_body, toSun_body.xyz, toSun_body.w);
  return mix(albedo, lit, switches.x);
#endif
}
