#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "geo/ellipsoid.h"
#include "scene/cut_node.h"
#include "scene/view_frustum.h"
#include "scene/view_leeway.h"

namespace tellurion::scene {

/// What an eye sees of the tiles of a cut, and how large. One thread only: in the facts it keeps where it looks
/// first (TileFacts::partInSight).
class CutSight {
 public:
  /// looksAhead: what may come into the picture soon counts as seen, CutOptions::margin beyond its sides and a little
  /// over the horizon.
  /// fadesIn: what is not in the picture itself counts the less, the nearer it is to the end of that margin, where
  /// nothing is known of the ground any more. So what comes into the margin, or leaves it, changes nothing at once.
  /// leeway: what may be seen from some of those views counts as seen, as near and large as it is for the nearest.
  CutSight(const View& view, const geo::Ellipsoid& ellipsoid, const CutOptions& options, double occluderDepth_m,
           bool looksAhead, bool fadesIn, const Leeway& leeway = {});

  enum class Found : std::uint8_t { seen, beyondFrustum, beyondHorizon };
  /// Fills in all of the node that its view decides. `parent` is null for a root, else something that is seen.
  Found look(CutNode& node, const CutNode* parent) const;
  /// How large it is on screen from its distance, and how much it needs its children for that.
  void measure(CutNode& node) const;

  /// `parents`: planes that all of its parent lies within, see ViewFrustum.
  bool maySee(TileFacts& facts, std::uint8_t parents) const;
  /// Of the picture, that a tile covers: screenShare().
  double share(const TileFacts& facts) const;
  double distance_m(const OrientedBox& box) const { return std::max(box.distance_m(view_.eye) - move_m_, 0.0); }
  double pixels(double length_m, double distance_m) const { return pixelsAcross(length_m, distance_m, pixelAngle_); }

 private:
  void fade(CutNode& node, const CutNode* parent) const;
  double shareOfMargin(const TileFacts& facts) const;
  std::optional<std::uint8_t> planesOfMargin(const TileFacts& facts, std::uint8_t parents) const;

  View view_;
  ViewFrustum picture_;
  ViewFrustum frustum_;  ///< with the margin
  geo::Horizon pictureHorizon_;
  geo::Horizon horizon_;  ///< with the eye lifted
  double move_m_;
  double pixelAngle_;
  double tolerance_px_;
  double texelTolerance_px_;
  double maxSpacing_px_;
  bool looksAhead_;
  bool fadesIn_;
  bool looksAllAround_;
};

}  // namespace tellurion::scene
