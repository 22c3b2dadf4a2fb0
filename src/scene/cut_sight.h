#pragma once

#include <cstdint>
#include <optional>

#include "geo/ellipsoid.h"
#include "scene/cut_node.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {

/// What an eye sees of the tiles of a cut, and how large. Immutable.
class CutSight {
 public:
  /// looksAhead: what may come into the picture soon counts as seen, CutOptions::margin beyond its sides and a little
  /// over the horizon.
  CutSight(const View& view, const geo::Ellipsoid& ellipsoid, const CutOptions& options, double occluderDepth_m,
           bool looksAhead);

  enum class Found : std::uint8_t { seen, beyondFrustum, beyondHorizon };
  /// Fills in all of the node that its view decides. `parent` is null for a root, else something that is seen.
  Found look(CutNode& node, const CutNode* parent) const;
  /// How large it is on screen from its distance, and how much it needs its children for that.
  void measure(CutNode& node) const;

  /// `parents`: planes that all of its parent lies within, see ViewFrustum.
  bool maySee(TileFacts& facts, std::uint8_t parents) const;
  /// Of the picture, that a tile covers: screenShare().
  double share(const TileFacts& facts) const;
  double distance_m(const OrientedBox& box) const { return box.distance_m(view_.eye); }
  double pixels(double length_m, double distance_m) const { return pixelsAcross(length_m, distance_m, pixelAngle_); }

 private:
  View view_;
  ViewFrustum picture_;
  ViewFrustum frustum_;   ///< with the margin
  geo::Horizon horizon_;  ///< likewise
  double pixelAngle_;
  double tolerance_px_;
  double texelTolerance_px_;
  double maxSpacing_px_;
  bool looksAhead_;
};

}  // namespace tellurion::scene
