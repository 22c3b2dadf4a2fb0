#pragma once

// The vector and matrix types of the whole project, and the only place that includes GLM. Explicit constructors are on,
// so a double never becomes a float unseen.
#ifndef GLM_FORCE_EXPLICIT_CTOR
#define GLM_FORCE_EXPLICIT_CTOR
#endif
#include <glm/glm.hpp>

namespace tellurion::geo {

using Vec2 = glm::dvec2;
using Vec3 = glm::dvec3;
using Vec4 = glm::dvec4;
using Mat3 = glm::dmat3;
using Mat4 = glm::dmat4;
using Vec2f = glm::fvec2;
using Vec3f = glm::fvec3;
using Vec4f = glm::fvec4;
using Mat3f = glm::fmat3;
using Mat4f = glm::fmat4;

using glm::cross;
using glm::dot;
using glm::length;
using glm::normalize;

/// v turned by the smallest rotation that takes the unit vector `from` to the unit vector `to`; -v where they are
/// opposite (within 1e-6 rad), for then any way is as short. Error about 1e-16 / (1 + cos of the angle between them).
Vec3 rotatedBetween(const Vec3& v, const Vec3& from, const Vec3& to);

}  // namespace tellurion::geo
