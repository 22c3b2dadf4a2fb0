#include "scene/view_frustum.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tellurion::scene {

ViewFrustum::ViewFrustum(const View& view, double margin, double move_m) : eye_(view.eye.m), slack_m_(move_m + 1e-6) {
  const geo::Mat3 bodyFromView = glm::transpose(view.viewFromBody);
  if (view.isAllAround) {  // planes that everything lies on
    inward_.fill(geo::Vec3(0.0));
    return;
  }
  const Sides sides = view.sides();
  const double halfX = 0.5 * sides.width() * (1.0 + margin);
  const double halfY = 0.5 * sides.height() * (1.0 + margin);
  // In view axes the picture is left <= x / -z <= right, bottom <= y / -z <= top.
  const std::array<geo::Vec3, 5> inView{geo::Vec3(-1.0, 0.0, -(sides.middleX() + halfX)),
                                        geo::Vec3(1.0, 0.0, sides.middleX() - halfX),
                                        geo::Vec3(0.0, -1.0, -(sides.middleY() + halfY)),
                                        geo::Vec3(0.0, 1.0, sides.middleY() - halfY), geo::Vec3(0.0, 0.0, -1.0)};
  std::transform(inView.begin(), inView.end(), inward_.begin(),
                 [&](const geo::Vec3& n) { return bodyFromView * geo::normalize(n); });
}

std::optional<std::uint8_t> ViewFrustum::planesAround(const OrientedBox& box, std::uint8_t within) const {
  const geo::Vec3 centre = box.centre.m - eye_;
  for (std::size_t i = 0; i < inward_.size(); ++i) {
    const auto bit = static_cast<std::uint8_t>(1u << i);
    if ((within & bit) != 0) continue;
    const geo::Vec3& n = inward_[i];
    double reach = slack_m_;
    for (const geo::Vec3& axis : box.halfAxes)
      reach += std::abs(geo::dot(axis, n));
    const double inside = geo::dot(centre, n);
    if (inside < -reach) return std::nullopt;
    if (inside >= reach) within |= bit;
  }
  return within;
}

bool ViewFrustum::mayShow(const geo::BodyPosition& centre, double radius_m) const {
  const geo::Vec3 fromEye = centre.m - eye_;
  return std::ranges::all_of(inward_, [&](const geo::Vec3& n) { return geo::dot(fromEye, n) >= -radius_m; });
}

std::array<double, 4> ViewFrustum::reachOverSides_m(const OrientedBox& box) const {
  const geo::Vec3 centre = box.centre.m - eye_;
  std::array<double, 4> reach{};
  for (std::size_t i = 0; i < reach.size(); ++i) {
    reach[i] = geo::dot(centre, inward_[i]);
    for (const geo::Vec3& axis : box.halfAxes)
      reach[i] += std::abs(geo::dot(axis, inward_[i]));
  }
  return reach;
}

bool isBeyondHorizonWithItsTop(const OrientedBox& box, const geo::Horizon& horizon) {
  for (unsigned i = OrientedBox::kCorners - 1; i-- > 0;) {
    if (!horizon.hides(box.corner(i))) return false;
  }
  return true;
}

double clearanceOfHorizon(const OrientedBox& box, const geo::Horizon& horizon) {
  double most = -std::numeric_limits<double>::infinity();
  for (unsigned i = 0; i < OrientedBox::kCorners; ++i)
    most = std::max(most, horizon.clearance(box.corner(i)));
  return most;
}

}  // namespace tellurion::scene
