// How a ray goes through the air (AirView), and where the table has it.

struct AirRay {
  float begins;   // metres to the air
  float length;   // of the way through it, as far as the table goes
  float bending;  // how distances are spread: kNearFine and so on
};

const float kNearFine = 0.0f;
const float kFarFine = 1.0f;
const float kEven = 2.0f;

// Place of a share of the way, and back.
float placeOfShare(float share, float bending) {
  float root = sqrt(bending == kFarFine ? 1.0f - share : share);
  return bending == kNearFine ? root : bending == kFarFine ? 1.0f - root : share;
}
float shareOfPlace(float place, float bending) {
  return bending == kNearFine ? place * place : bending == kFarFine ? place * (2.0f - place) : place;
}

float bendingOf(AirView view, float cosine, bool meets) {
  return view.side.w == kEyeLow ? kNearFine : meets ? kFarFine : cosine > 0.0f ? kEven : kNearFine;
}

// Squares of metres, from the place on a ray that is nearest to the centre back to where it meets the top, and the bottom:
// below 0 where it passes above that.
vec2 waysToNearest2(AirView view, float sine, float cosine, float past) {
  float r = view.scale.w;
  float down = r * cosine;
  float steep = view.top.x * cosine;
  float level = view.top.y * sine;
  float toTop2 = view.side.w == kEyeOutside ? r * r * max((steep - level) * (steep + level), 0.0f) : view.top.w + down * down;
  return vec2(toTop2, -r * r * past * (view.horizon.x * cosine + view.horizon.y * sine));
}

// The way of a ray through the air. sine and cosine are of its angle from the nadir, past that of the angle beyond the
// horizon; meets: whether it ends at the bottom.
AirRay rayThroughAir(AirView view, float sine, float cosine, float past, bool meets) {
  AirRay ray;
  bool outside = view.side.w == kEyeOutside;
  float down = view.scale.w * cosine;
  vec2 ways2 = waysToNearest2(view, sine, cosine, past);
  float toTop = sqrt(ways2.x);
  float toBottom = sqrt(max(ways2.y, 0.0f));
  ray.begins = outside ? -view.top.w / max(down + toTop, 1.0f) : 0.0f;
  float leaves = outside ? 2.0f * toTop : down > 0.0f ? down + toTop : view.top.w / max(toTop - down, 1e-3f);
  float meetsAt = outside ? view.top.z / max(toTop + toBottom, 1.0f) : view.top.z / max(down + toBottom, 1e-3f);
  ray.length = max(meets ? meetsAt : leaves, 1.0f);
  if (outside && !meets && cosine <= 0.0f) ray.length = 1.0f;
  ray.bending = bendingOf(view, cosine, meets);
  return ray;
}

// direction: unit vector.
struct AirDirection {
  float sine;  // of the angle from the nadir
  float cosine;
  float past;      // sine of the angle beyond the horizon
  float tangent;   // of half of it
  float sideways;  // along airView.side
};

AirDirection airDirection(AirView view, vec3 direction) {
  AirDirection d;
  d.cosine = -dot(direction, vec3(view.up));
  d.sideways = dot(direction, vec3(view.side));
  vec3 level = direction + d.cosine * vec3(view.up);
  d.sine = sqrt(dot(level, level));
  d.past = d.sine * view.horizon.y - d.cosine * view.horizon.x;
  d.tangent = d.past / max(1.0f + d.cosine * view.horizon.y + d.sine * view.horizon.x, 1e-6f);
  return d;
}

vec2 airTableDirection(AirDirection d, bool meets, float from) {
  float azimuth = sqrt(clamp(0.5f - 0.5f * d.sideways / max(d.sine, 1e-9f), 0.0f, 1.0f));
  float row = 0.5f + (meets ? from * float(kViewBelow - 1) : float(kViewBelow) + from * float(kViewAbove - 1));
  return vec2((0.5f + azimuth * float(kViewAzimuths - 1)) / float(kViewAzimuths), row / float(kViewRows));
}

vec3 airTablePlace(vec2 direction, float share, float bending) {
  float place = placeOfShare(share, bending);
  return vec3(direction, (0.5f + place * float(kViewDistances - 1)) / float(kViewDistances));
}

// Of the whole way through the air, of a ray that meets nothing, whatever the bottom. direction: unit vector.
vec3 airPlaceOfSky(AirView view, vec3 direction) {
  AirDirection d = airDirection(view, direction);
  float from = pow(clamp(d.tangent * view.horizon.w, 0.0f, 1.0f), 1.0f / 3.0f);
  return vec3(airTableDirection(d, false, from), (0.5f + float(kViewDistances - 1)) / float(kViewDistances));
}

// The share of the way through the air as far as ground at this distance, and height. Seen from above the air, it is the
// height that counts: triangles cut through the ground's curve, by kilometres where a pixel is as large. As
// rayThroughAir has the way, in one division.
float shareToGround(AirModel air, AirView view, AirDirection d, bool meets, float distance, float height) {
  bool outside = view.side.w == kEyeOutside;
  float down = view.scale.w * d.cosine;
  vec2 ways2 = waysToNearest2(view, d.sine, d.cosine, d.past);
  float toTop = sqrt(ways2.x);
  float toBottom = sqrt(max(ways2.y, 0.0f));
  float depth = air.sphere.z - air.sphere.y;
  float over = clamp(height - air.sphere.y, 0.0f, depth);
  float twice = 2.0f * (air.sphere.x + air.sphere.y);
  float toGround = sqrt(max(ways2.y + over * (twice + over), 0.0f));
  // Of a fraction each: metres passed in the air, and what they are a share of.
  vec2 passed = outside ? vec2((depth - over) * (twice + depth + over), max(toTop + toGround, 1.0f)) : vec2(distance, 1.0f);
  vec2 length_ = meets ? vec2(view.top.z, max((outside ? toTop : down) + toBottom, 1e-3f))
               : outside || down > 0.0f ? vec2((outside ? toTop : down) + toTop, 1.0f)
                                        : vec2(view.top.w, max(toTop - down, 1e-3f));
  return clamp(passed.x * length_.y / max(passed.y * length_.x, 1e-3f), 0.0f, 1.0f);
}

// The table's place of ground at place_air.xyz, relative to the eye, place_air.w above the ellipsoid; w: the share of the
// way.
vec4 airPlaceOfGround(AirModel air, AirView view, vec4 place_air) {
  float distance2 = max(dot(place_air.xyz, place_air.xyz), 1e-12f);
  float perMetre = inversesqrt(distance2);
  AirDirection d = airDirection(view, place_air.xyz * perMetre);
  bool meets = d.tangent < 0.0f;
  float share = shareToGround(air, view, d, meets, distance2 * perMetre, place_air.w);
  float from = clamp(d.tangent * (meets ? view.horizon.z : view.horizon.w), 0.0f, 1.0f);
  from = meets ? sqrt(from) : pow(from, 1.0f / 3.0f);
  return vec4(airTablePlace(airTableDirection(d, meets, from), share, bendingOf(view, d.cosine, meets)), share);
}
