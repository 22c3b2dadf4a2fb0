#include "scene/screen_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "scene/picture_projection.h"

namespace tellurion::scene {
namespace {

/// Ground fills about so much of its box's height.
constexpr double kFilled = 0.5;

/// Right and up in half pictures, times the distance along the line of sight, which is z.
using Sighted = geo::Vec3;

/// The part of a convex polygon that lies in the picture.
class Clipped {
 public:
  explicit Clipped(const std::array<Sighted, 4>& corners) : count_(corners.size()) {
    std::ranges::copy(corners, points_.begin());
    constexpr double kNearest_m = 0.1;
    keep([](const Sighted& p) { return p.z - kNearest_m; });
    keep([](const Sighted& p) { return p.z + p.x; });
    keep([](const Sighted& p) { return p.z - p.x; });
    keep([](const Sighted& p) { return p.z + p.y; });
    keep([](const Sighted& p) { return p.z - p.y; });
  }

  /// Of the picture.
  double share() const {
    double twice = 0.0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Sighted& a = points_[i];
      const Sighted& b = points_[(i + 1) % count_];
      twice += (a.x * b.y - b.x * a.y) / (a.z * b.z);
    }
    return std::abs(twice) / 8.0;
  }

 private:
  /// What lies on the side of a plane where `height` is not below 0.
  template <class Height>
  void keep(const Height& height) {
    std::array<Sighted, kMost> kept;
    std::size_t count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Sighted& a = points_[i];
      const Sighted& b = points_[(i + 1) % count_];
      const double above = height(a);
      const double next = height(b);
      if (above >= 0.0) kept[count++] = a;
      if ((above >= 0.0) != (next >= 0.0)) kept[count++] = a + (b - a) * (above / (above - next));
    }
    points_ = kept;
    count_ = count;
  }

  static constexpr std::size_t kMost = 10;  ///< corners: four, and one more for each plane at most
  std::array<Sighted, kMost> points_;
  std::size_t count_;
};

double shareOfPicture(const OrientedBox& box, const geo::BodyPosition& eye, const geo::Mat3& viewFromBody,
                      const Sides& sides) {
  const auto sighted = [&](const geo::Vec3& fromEye) {
    const geo::Vec3 seen = viewFromBody * fromEye;
    return Sighted((seen.x + sides.middleX() * seen.z) / (0.5 * sides.width()),
                   (seen.y + sides.middleY() * seen.z) / (0.5 * sides.height()), -seen.z);
  };
  const geo::Vec3 centre = box.centre - eye;
  std::array<geo::Vec3, 3> axes = box.halfAxes;
  axes[2] *= kFilled;
  double share = 0.0;
  bool isOutside = false;
  // The faces towards the eye cover what the box covers, without overlap.
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const geo::Vec3& out = axes[i];
    const double along = geo::dot(centre, out);
    if (std::abs(along) <= geo::dot(out, out)) continue;
    isOutside = true;
    const geo::Vec3 middle = along > 0.0 ? centre - out : centre + out;
    const geo::Vec3& u = axes[(i + 1) % 3];
    const geo::Vec3& v = axes[(i + 2) % 3];
    share +=
        Clipped({sighted(middle - u - v), sighted(middle + u - v), sighted(middle + u + v), sighted(middle - u + v)})
            .share();
  }
  return isOutside ? std::min(share, 1.0) : 1.0;
}

}  // namespace

double screenShare(const OrientedBox& box, const View& view) {
  if (!view.isAllAround) return shareOfPicture(box, view.eye, view.viewFromBody, view.sides());
  double share = 0.0;
  for (const geo::Mat3& faceFromView : kCubeFaces)
    share += shareOfPicture(box, view.eye, faceFromView * view.viewFromBody, Sides{});
  return share / static_cast<double>(kCubeFaces.size());
}

}  // namespace tellurion::scene
