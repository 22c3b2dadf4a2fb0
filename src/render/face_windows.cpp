#include "render/face_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/warp_shape.h"

namespace tellurion::render {
namespace {

namespace warping {
using glm::length;
using glm::vec2;
using glm::vec4;
using std::cos;
using std::max;
using std::min;
using std::sin;
#include "render/shaders/warp_direction.glsl"
}  // namespace warping

// Directions are looked at this many pixels apart. Between two of them the place on a face moves by up to three texels
// a pixel: in its corner a texel is a third as large outwards as in its middle.
constexpr int kStep = 4;
constexpr int kBetween = 3 * kStep;
constexpr int kFilter = 2;  ///< texels beyond a face that filtering reads

struct Bounds {
  double left = std::numeric_limits<double>::infinity();
  double right = -left;
  double top = left;
  double bottom = -left;
};

/// Every so many from 0, and the last.
template <class Visit>
void visitSteps(int count, const Visit& visit) {
  for (int i = 0; i < count - 1; i += kStep)
    visit(i);
  visit(count - 1);
}

geo::Vec3 directionOf(const geo::Vec4f& direction) {
  return {direction.x, direction.y, direction.z};
}

}  // namespace

geo::Vec4f shapeOf(const scene::Warp& warp) {
  return {static_cast<float>(warp.size.width), static_cast<float>(warp.size.height),
          static_cast<float>(scene::pixelAngle(warp)),
          warp.projection == scene::Projection::equirectangular ? 1.0f : 0.0f};
}

int faceSideOf(const scene::Warp& warp) {
  return std::max(static_cast<int>(std::ceil(2.0 / scene::pixelAngle(warp) - 1e-6)), 2);
}

std::vector<FaceWindow> windowsOf(const scene::Warp& warp, const scene::PixelRect& piece) {
  const geo::Vec4f shape = shapeOf(warp);
  const int side = faceSideOf(warp);
  // A fisheye's circle may touch a pixel between those that are looked at.
  const double radius = 0.5 * std::min(warp.size.width, warp.size.height) + 2 * kStep;
  const double over = 1.0 + 2.0 * kBetween / side;
  std::array<Bounds, scene::kCubeFaces.size()> bounds;
  const auto look = [&](int col, int row) {
    const double x = col + 0.5;
    const double y = row + 0.5;
    if (shape.w < 0.5f && std::hypot(x - 0.5 * warp.size.width, y - 0.5 * warp.size.height) > radius) return;
    const geo::Vec3 direction =
        directionOf(warping::warpDirection(shape, {static_cast<float>(x), static_cast<float>(y)}));
    for (std::size_t face = 0; face < bounds.size(); ++face) {
      const geo::Vec3 p = scene::kCubeFaces[face] * direction;
      if (!(std::max(std::abs(p.x), std::abs(p.y)) <= -p.z * over)) continue;
      Bounds& b = bounds[face];
      b.left = std::min(b.left, p.x / -p.z);
      b.right = std::max(b.right, p.x / -p.z);
      b.top = std::min(b.top, -p.y / -p.z);
      b.bottom = std::max(b.bottom, -p.y / -p.z);
    }
  };
  visitSteps(piece.height,
             [&](int row) { visitSteps(piece.width, [&](int col) { look(piece.left + col, piece.top + row); }); });
  std::vector<FaceWindow> windows;
  const auto texel = [&](double along, int away) {
    const double at = (along + 1.0) * 0.5 * side;
    return std::clamp(static_cast<int>(std::floor(at)) + away, -kFilter, side + kFilter);
  };
  for (std::size_t face = 0; face < bounds.size(); ++face) {
    const Bounds& b = bounds[face];
    if (!(b.left <= b.right)) continue;
    const int left = texel(b.left, -kBetween - kFilter);
    const int top = texel(b.top, -kBetween - kFilter);
    windows.push_back(
        {face,
         side,
         {left, top, texel(b.right, kBetween + kFilter + 1) - left, texel(b.bottom, kBetween + kFilter + 1) - top}});
  }
  return windows;
}

scene::View viewOf(const FaceWindow& window, const scene::EyePicture& eye) {
  scene::View face = eye.cut;
  face.isAllAround = false;
  face.viewFromBody = scene::kCubeFaces[window.face] * eye.warpFromView * eye.cut.viewFromBody;
  face.viewport = {.width = window.side, .height = window.side};
  face.offAxis = scene::Sides{};
  return scene::partOf(face, window.texels);
}

std::optional<scene::PixelRect> texelUnder(const scene::Warp& warp, const FaceWindow& window, int col, int row) {
  const geo::Vec4f direction =
      warping::warpDirection(shapeOf(warp), {static_cast<float>(col) + 0.5f, static_cast<float>(row) + 0.5f});
  const geo::Vec3 p = scene::kCubeFaces[window.face] * directionOf(direction);
  if (direction.w < 0.5f || std::max(std::abs(p.x), std::abs(p.y)) > -p.z) return std::nullopt;
  const auto texel = [&](double along) { return static_cast<int>(std::floor((along + 1.0) * 0.5 * window.side)); };
  return scene::PixelRect{texel(p.x / -p.z) - window.texels.left, texel(-p.y / -p.z) - window.texels.top, 1, 1};
}

}  // namespace tellurion::render
