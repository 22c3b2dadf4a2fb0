#include "scene/cut_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/screen_share.h"

namespace tellurion::scene {
namespace {

constexpr double kLift = 0.05;  ///< of the eye's height: what comes over the horizon soon

geo::BodyPosition lifted(const geo::BodyPosition& eye, const geo::Ellipsoid& ellipsoid) {
  const geo::Geodetic place = ellipsoid.geodeticFromBody(eye);
  return eye + geo::directionFromLatLon(place.lat, place.lon).n * (kLift * std::max(place.height_m, 100.0));
}

/// Its ground lies in both boxes, and in its parent's.
std::optional<std::uint8_t> planesAround(const ViewFrustum& frustum, const TileFacts& facts, std::uint8_t parents) {
  if (parents == ViewFrustum::kAllPlanes) return parents;
  const auto inside = frustum.planesAround(facts.box, parents);
  return inside && facts.drawable ? frustum.planesAround(facts.tightBox, *inside) : inside;
}

/// The part that was in sight last is looked at first: mostly it still is.
bool areHidden(TileFacts& facts, const geo::Horizon& horizon) {
  const std::size_t count = facts.parts.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t part = (facts.partInSight + i) % count;
    if (isBeyondHorizon(facts.parts[part], horizon)) continue;
    facts.partInSight = part;
    return false;
  }
  return count > 0;
}

bool isHidden(TileFacts& facts, const geo::Horizon& horizon) {
  if (isBeyondHorizon(facts.box, horizon)) return true;
  return facts.drawable && (isBeyondHorizon(facts.tightBox, horizon) || areHidden(facts, horizon));
}

/// Of something that reaches into a border from outside: by how much it is within the inner end of that, and within the
/// outer, negative where it is not.
double shareBetween(double inner, double outer) {
  if (inner >= 0.0) return 1.0;
  return std::max(outer, 0.0) / (std::max(outer, 0.0) - inner);
}

}  // namespace

CutSight::CutSight(const View& view, const geo::Ellipsoid& ellipsoid, const CutOptions& options, double occluderDepth_m,
                   bool looksAhead, bool fadesIn, const Leeway& leeway)
    : view_(view),
      picture_(view, leeway.turn, leeway.move_m),
      frustum_(view, std::max(looksAhead && std::isfinite(options.margin) ? options.margin : 0.0, leeway.turn),
               leeway.move_m),
      pictureHorizon_(ellipsoid.horizon(view.eye, occluderDepth_m, leeway.move_m)),
      horizon_(ellipsoid.horizon(looksAhead ? lifted(view.eye, ellipsoid) : view.eye, occluderDepth_m, leeway.move_m)),
      move_m_(leeway.move_m),
      pixelAngle_(view.pixelAngle()),
      tolerance_px_(options.tolerance_px),
      texelTolerance_px_(options.texelTolerance_px),
      maxSpacing_px_(options.maxSpacing_px),
      looksAhead_(looksAhead),
      fadesIn_(fadesIn),
      looksAllAround_(looksAhead && !std::isfinite(options.margin)) {}

bool CutSight::maySee(TileFacts& facts, std::uint8_t parents) const {
  return planesOfMargin(facts, parents) && !isHidden(facts, horizon_);
}

std::optional<std::uint8_t> CutSight::planesOfMargin(const TileFacts& facts, std::uint8_t parents) const {
  return looksAllAround_ ? ViewFrustum::kAllPlanes : planesAround(frustum_, facts, parents);
}

double CutSight::share(const TileFacts& facts) const {
  return screenShare(facts.drawable ? facts.tightBox : facts.box, view_);
}

CutSight::Found CutSight::look(CutNode& node, const CutNode* parent) const {
  const auto inside = planesOfMargin(*node.facts, parent != nullptr ? parent->inside : std::uint8_t{0});
  if (!inside) return Found::beyondFrustum;
  if (isHidden(*node.facts, horizon_)) return Found::beyondHorizon;
  node.seen = true;
  node.inside = *inside;
  if (!looksAhead_) {
    node.shown = true;
  } else if (parent == nullptr || parent->shown) {
    const auto insidePicture =
        planesAround(picture_, *node.facts, parent != nullptr ? parent->insidePicture : std::uint8_t{0});
    node.shown = insidePicture.has_value() && !isHidden(*node.facts, pictureHorizon_);
    node.insidePicture = insidePicture.value_or(0);
  }
  // Its ground lies in its parent's box as well.
  node.distance_m = distance_m(node.facts->drawable ? node.facts->tightBox : node.facts->box);
  if (parent != nullptr) node.distance_m = std::max(node.distance_m, parent->distance_m);
  measure(node);
  if (fadesIn_ && !node.shown) fade(node, parent);
  return Found::seen;
}

void CutSight::fade(CutNode& node, const CutNode* parent) const {
  node.presence = std::min(static_cast<float>(shareOfMargin(*node.facts)), parent != nullptr ? parent->presence : 1.0f);
  for (double* size : {&node.error_px, &node.texel_px, &node.spacing_px, &node.need})
    *size *= static_cast<double>(node.presence);
}

/// 1 up to the middle of the margin, so that what touches the picture counts in full; 0 where the margin ends.
double CutSight::shareOfMargin(const TileFacts& facts) const {
  const auto clearance = [&](const geo::Horizon& horizon) {
    double parts = facts.parts.empty() ? std::numeric_limits<double>::infinity() : -1.0;
    for (const OrientedBox& part : facts.parts)
      parts = std::max(parts, clearanceOfHorizon(part, horizon));
    return std::min({clearanceOfHorizon(facts.box, horizon), clearanceOfHorizon(facts.tightBox, horizon), parts});
  };
  double share = shareBetween(clearance(pictureHorizon_), clearance(horizon_));
  if (looksAllAround_) return std::min(2.0 * share, 1.0);
  for (const OrientedBox* box : {&facts.box, &facts.tightBox}) {
    const auto inner_m = picture_.reachOverSides_m(*box);
    const auto outer_m = frustum_.reachOverSides_m(*box);
    for (std::size_t i = 0; i < inner_m.size(); ++i)
      share = std::min(share, shareBetween(inner_m[i], outer_m[i]));
  }
  return std::min(2.0 * share, 1.0);
}

void CutSight::measure(CutNode& node) const {
  node.error_px = pixels(node.facts->error_m, node.distance_m);
  node.texel_px = pixels(node.facts->texel_m, node.distance_m);
  node.spacing_px = pixels(node.facts->spacing_m, node.distance_m);
  if (!node.facts->drawable) return;
  node.need =
      std::max({node.error_px / tolerance_px_, node.texel_px / texelTolerance_px_, node.spacing_px / maxSpacing_px_});
}

}  // namespace tellurion::scene
