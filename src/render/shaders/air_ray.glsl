// How a ray goes through the air (AirView), and where the table has it.

struct AirRay {
  vec2 direction;  // place in the table
  float begins;    // metres to the air
  float length;    // of the way through it, as far as the table goes
  float bending;   // how distances are spread: kNearFine and so on
  float toTop;     // metres, from the place on it that is nearest to the centre back to where it meets the top
  float bottom2;   // square of that to the bottom; below 0 where it passes above
};

const float kNearFine = 0.0f;
const float kFarFine = 1.0f;
const float kEven = 2.0f;

// Place of a share of the way, and back.
float placeOfShare(float share, float bending) {
  return bending == kNearFine ? sqrt(share) : bending == kFarFine ? 1.0f - sqrt(1.0f - share) : share;
}
float shareOfPlace(float place, float bending) {
  return bending == kNearFine ? place * place : bending == kFarFine ? place * (2.0f - place) : place;
}

// The way of a ray through the air. sine and cosine are of its angle from the nadir, past that of the angle beyond the
// horizon; meets: whether it ends at the bottom.
AirRay rayThroughAir(AirView view, float sine, float cosine, float past, bool meets) {
  AirRay ray;
  float r = view.scale.w;
  bool outside = view.side.w == kEyeOutside;
  float down = r * cosine;
  float toTop2 = outside ? r * r * max((view.top.x * cosine - view.top.y * sine) * (view.top.x * cosine + view.top.y * sine), 0.0f)
                         : view.top.w + down * down;
  float half_ = sqrt(toTop2);
  ray.toTop = half_;
  ray.bottom2 = -r * r * past * (view.horizon.x * cosine + view.horizon.y * sine);
  float bottomHalf = sqrt(max(ray.bottom2, 0.0f));
  ray.begins = outside ? -view.top.w / max(down + half_, 1.0f) : 0.0f;
  float leaves = outside ? 2.0f * half_ : down > 0.0f ? down + half_ : view.top.w / max(half_ - down, 1e-3f);
  float meetsAt = outside ? view.top.z / max(half_ + bottomHalf, 1.0f)
                          : view.top.z / max(down + bottomHalf, 1e-3f);
  ray.length = max(meets ? meetsAt : leaves, 1.0f);
  if (outside && !meets && cosine <= 0.0f) ray.length = 1.0f;
  ray.bending = view.side.w == kEyeLow ? kNearFine : meets ? kFarFine : cosine > 0.0f ? kEven : kNearFine;
  ray.direction = vec2(0.0f);
  return ray;
}

// direction: unit vector. sky: nothing is met, whatever the bottom.
AirRay airRay(AirView view, vec3 direction, bool sky) {
  vec3 up = vec3(view.up);
  vec3 side = vec3(view.side);
  float cosine = -dot(direction, up);
  float sideways = dot(direction, side);
  float across = dot(direction, cross(up, side));
  float sine = sqrt(sideways * sideways + across * across);
  float past = sine * view.horizon.y - cosine * view.horizon.x;
  float tangent = past / max(1.0f + cosine * view.horizon.y + sine * view.horizon.x, 1e-6f);
  bool meets = tangent < 0.0f && !sky;
  AirRay ray = rayThroughAir(view, sine, cosine, past, meets);
  float azimuth = sqrt(clamp(0.5f - 0.5f * sideways / max(sine, 1e-9f), 0.0f, 1.0f));
  float share = clamp(tangent * (meets ? view.horizon.z : view.horizon.w), 0.0f, 1.0f);
  float from = meets ? sqrt(share) : pow(share, 1.0f / 3.0f);
  float row = (meets ? 0.5f : float(kViewHalf) + 0.5f) + from * float(kViewHalf - 1);
  ray.direction = vec2((0.5f + azimuth * float(kViewAzimuths - 1)) / float(kViewAzimuths), row / float(2 * kViewHalf));
  return ray;
}

vec3 airTablePlace(AirRay ray, float share) {
  float place = placeOfShare(share, ray.bending);
  return vec3(ray.direction.x, ray.direction.y, (0.5f + place * float(kViewDistances - 1)) / float(kViewDistances));
}

// The share of the way through the air as far as ground at this distance, and height. Seen from above the air, it is the
// height that counts: triangles cut through the ground's curve, by kilometres where a pixel is as large.
float shareToGround(AirModel air, AirView view, AirRay ray, float distance, float height) {
  float passed = distance - ray.begins;
  if (view.side.w == kEyeOutside) {
    float depth = air.sphere.z - air.sphere.y;
    float over = clamp(height - air.sphere.y, 0.0f, depth);
    float bottom = air.sphere.x + air.sphere.y;
    float ground2 = max(ray.bottom2 + over * (2.0f * bottom + over), 0.0f);
    passed = (depth - over) * (2.0f * bottom + depth + over) / max(ray.toTop + sqrt(ground2), 1.0f);
  }
  return clamp(passed / ray.length, 0.0f, 1.0f);
}
