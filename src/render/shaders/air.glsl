// Ground and sky through the air.
layout(binding = 18) uniform sampler3D airLight;  // rgb: light that the air adds up to there, for each share of the way
layout(binding = 19) uniform sampler2D airDepth;  // rgb: optical depth, likewise; the same all around
layout(binding = 20) uniform sampler2DArray groundLight;  // of the sun; of the sky

// As the eye, or a film, takes light: as it is up to the knee, and nothing beyond 1.
vec3 exposed(vec3 light) {
  vec3 over = max(light - kShoulderBegins, 0.0);
  return min(light, kShoulderBegins) + over / (1.0 + over / (1.0 - kShoulderBegins));
}

// What is left of a picture's 8 bits: light moved by less than half a step of 1/255 of sRGB, another way in
// each pixel, so that what changes slowly does not fall into bands. Interleaved gradient noise (Jimenez 2014); the step is the slope of
// sRGB's curve, 2.275 light^0.583 beyond its straight part, within a sixth.
vec3 dithered(vec3 light, vec2 pixel) {
  float noise = fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5;
  vec3 root = sqrt(light);
  vec3 step_ = max(2.275 * root * (0.7 + 0.3 * root), vec3(1.0 / 12.92)) / 255.0;
  return light + (noise * kDither) * step_;
}

// Light that leaves ground at this height above the ellipsoid; vectors are in body axes, and mirrored is, as in litGround.
vec3 litGroundInAir(vec3 albedo, float mirrored, float height, vec3 normal_body, vec3 up_body, vec3 toSun_body) {
  vec2 place = groundLightPlace(air, height, dot(up_body, toSun_body));
  vec3 sun = texture(groundLight, vec3(place, 0.0)).rgb;
  vec3 fromSun = sun * max(dot(normal_body, toSun_body), 0.0);
  vec3 sky = texture(groundLight, vec3(place, 1.0)).rgb * (0.5 + 0.5 * dot(normal_body, up_body));
  return albedo * (fromSun + sky) + sun * mirrored;
}

// What reaches the eye from ground at place_air.xyz, relative to the eye, place_air.w above the ellipsoid. Lamps are not exposed: their strength is a
// picture's, not a power.
vec3 throughAir(vec3 light, vec3 lamps, vec4 place_air) {
  vec4 place = airPlaceOfGround(air, airView, place_air);
  vec3 reaches = exp(-place.w * texture(airDepth, place.yz).rgb);
  vec3 added = place.w * texture(airLight, place.xyz).rgb;
  return exposed((light * reaches + added) * airView.up.w + lamps * reaches);
}
