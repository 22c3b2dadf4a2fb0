#include "geo/vector.h"

namespace tellurion::geo {

// Rodrigues' formula, the sine being the length of the axis.
Vec3 rotatedBetween(const Vec3& v, const Vec3& from, const Vec3& to) {
  const Vec3 axis = cross(from, to);
  const double cosine = dot(from, to);
  if (cosine < -1.0 + 1e-12) return -v;
  return v * cosine + cross(axis, v) + axis * (dot(axis, v) / (1.0 + cosine));
}

}  // namespace tellurion::geo
