// What is between the eye and what stands behind the air.
struct Between {
  vec3 reaches;  // of light from there
  float glare;   // brightness of the air before it, as drawn
};
Between airBetween(vec3 direction_body) {
  vec3 place = airPlaceOfSky(airView, normalize(direction_body * airView.scale.xyz));
  vec3 light = exposed(textureLod(airLight, place, 0.0).rgb * airView.up.w);
  return Between(exp(-textureLod(airDepth, place.yz, 0.0).rgb), dot(light, vec3(0.2126, 0.7152, 0.0722)));
}
vec3 asSeen(vec3 light) {
  return exposed(light * airView.up.w);
}
