// The end of every shader of the terrain: albedo and the strengths of lamps and of water, lit.
in vec4 textureCoordinates;
in vec3 upInterpolated_body;
flat in ivec4 textureLayers;

#ifdef MIRROR
in vec3 place_rte;
#endif

#ifdef AIR
in vec4 place_air;  // relative to the eye; w: height above the ellipsoid
#endif

layout(location = 0) out vec4 colour;

vec3 shadedGround(vec3 albedo, float lamps, float water) {
  vec3 relief = reliefFromTexel(reliefTexel(max(textureLayers.y, 0), textureCoordinates.zw));
  vec3 up_body = normalize(upInterpolated_body);
  vec3 normal_body = exaggeratedNormal(up_body + relief * float(textureLayers.y >= 0), up_body, switches.y + 1.0);
  float mirrored = 0.0;
#ifdef MIRROR
  if (water > 0.0) {
    normal_body = normalize(mix(normal_body, up_body, min(water, 1.0)));  // no relief of what lies below
    mirrored = water * sunInWater(-normalize(place_rte), up_body, toSun_body.xyz);
  }
#endif
#ifdef AIR
  vec3 light = litGroundInAir(albedo, mirrored, place_air.w, normal_body, up_body, toSun_body.xyz);
  return dithered(throughAir(light, lampLight(lamps, dot(up_body, toSun_body.xyz)), place_air), gl_FragCoord.xy);
#else
  vec3 lit = litGround(albedo, mirrored, lamps, normal_body, up_body, toSun_body.xyz, toSun_body.w);
  return mix(albedo, lit, switches.x);
#endif
}
