// The table of the air as the eye sees it: one direction an invocation, from the eye, or from where the air begins, on.
// Single scattering along the way, with what is scattered more than once out of a table.
layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0) uniform sampler2D transmittance;
layout(binding = 1) uniform sampler2D glow;
layout(binding = 0, rgba32f) uniform writeonly image3D airLight;
layout(binding = 1, rgba32f) uniform writeonly image2D airDepth;  // of the first azimuth

const int kStepsADistance = 2;

// A ray, seen from the place on it that is nearest to the centre.
struct Line {
  float nearest;       // metres from the centre
  float sunAtNearest;  // cosine of the sun there, times that
  float sunAlong;      // cosine between ray and sun
};

float heightAt(Line line, float along) {
  // sqrt(a^2 + b^2) - r without its cancellation
  float r = air.sphere.x;
  float square = (line.nearest - r) * (line.nearest + r) + along * along;
  return square / (sqrt(line.nearest * line.nearest + along * along) + r);
}

struct Lit {
  vec3 light;
  vec3 lost;
};

// What a metre adds and loses.
Lit litAt(Line line, float along, vec3 densities) {
  float height = heightAt(line, along);
  float sun = clamp((line.sunAtNearest + along * line.sunAlong) / (air.sphere.x + height), -1.0, 1.0);
  vec3 sunlight = texture(transmittance, transmittancePlace(air, height, sun)).rgb * sunVisible(air, height, sun);
  vec3 around = texture(glow, glowPlace(air, height, sun)).rgb;
  return Lit(scattered(air, densities, line.sunAlong, sunlight, around), extinction(air, densities));
}

void main() {
  ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
  float azimuthPlace = float(texel.x) / float(kViewAzimuths - 1);
  bool meets = texel.y < kViewBelow;
  float from = meets ? float(texel.y) / float(kViewBelow - 1) : float(texel.y - kViewBelow) / float(kViewAbove - 1);
  float tangent = meets ? from * from / airView.horizon.z : from * from * from / airView.horizon.w;
  // Angle past the horizon out of the tangent of its half, and from there the ray.
  float scale = 1.0 / (1.0 + tangent * tangent);
  float past = 2.0 * tangent * scale;
  float pastCosine = (1.0 - tangent * tangent) * scale;
  float sine = max(past * airView.horizon.y + pastCosine * airView.horizon.x, 0.0);
  float cosine = pastCosine * airView.horizon.y - past * airView.horizon.x;
  AirRay ray = rayThroughAir(airView, sine, cosine, past, meets);

  float towards = 1.0 - 2.0 * azimuthPlace * azimuthPlace;  // cosine of the azimuth
  vec3 toSun = vec3(airView.toSun);
  float sunUp = dot(toSun, vec3(airView.up));
  float sunSide = dot(toSun, vec3(airView.side));
  Line line = Line(airView.scale.w * sine, airView.scale.w * sine * (sunSide * cosine * towards + sunUp * sine),
                   sunSide * sine * towards - sunUp * cosine);

  float start = ray.begins - airView.scale.w * cosine;
  vec3 light = vec3(0.0);
  vec3 depth = vec3(0.0);
  float along = start;
  float height = heightAt(line, along);
  vec3 densities = densitiesAt(air, height);
  Lit first = litAt(line, along, densities);
  imageStore(airLight, ivec3(texel, 0), vec4(first.light * ray.length, 0.0));
  if (texel.x == 0) imageStore(airDepth, ivec2(texel.y, 0), vec4(first.lost * ray.length, 0.0));
  for (int i = 1; i < kViewDistances; ++i) {
    for (int k = 1; k <= kStepsADistance; ++k) {
      float place = (float(i - 1) + float(k) / float(kStepsADistance)) / float(kViewDistances - 1);
      float next = start + ray.length * shareOfPlace(place, ray.bending);
      float nextHeight = heightAt(line, next);
      vec3 nextDensities = densitiesAt(air, nextHeight);
      vec3 mean = meanDensities(air, densities, nextDensities, nextHeight - height);
      Lit lit = litAt(line, 0.5 * (along + next), mean);
      vec3 lost = lit.lost * (next - along);
      vec3 kept = mix((1.0 - exp(-lost)) / max(lost, 1e-9), 1.0 - 0.5 * lost, lessThan(lost, vec3(0.01)));
      light += exp(-depth) * lit.light * kept * (next - along);
      depth += lost;
      along = next;
      height = nextHeight;
      densities = nextDensities;
    }
    float share = shareOfPlace(float(i) / float(kViewDistances - 1), ray.bending);
    imageStore(airLight, ivec3(texel, i), vec4(light / share, 0.0));
    if (texel.x == 0) imageStore(airDepth, ivec2(texel.y, i), vec4(depth / share, 0.0));
  }
}
