// What is between the eye and what stands behind the air, where there is none.
struct Between {
  vec3 reaches;
  float glare;
};
Between airBetween(vec3 direction_body) {
  return Between(vec3(1.0), 0.0);
}
vec3 asSeen(vec3 light) {
  return light;
}
