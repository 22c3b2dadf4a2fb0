#include "pyramid/fill_plan.h"

#include <algorithm>
#include <numeric>

namespace tellurion::pyramid {
namespace {

/// Samples of its own level. Four spread the step that is left at a level to a slope of a quarter of it a sample.
constexpr double kReach_samples = 4.0;

}  // namespace

double FillPlan::reachOfTiles(int level) const {
  return *std::max_element(reaches.begin() + level, reaches.end());
}

double FillPlan::reachDownTo(int level) const {
  return std::accumulate(reaches.begin(), reaches.begin() + level + 1, 0.0);
}

FillPlan fillPlan(const tiling::Tiling& tiling, int tileCells, const geo::Body& body, double limit_m, int fromLevel,
                  int deepestLevel) {
  FillPlan plan{.fromLevel = fromLevel, .baseFromLevel = fromLevel, .reaches = {}};
  for (int level = fromLevel + 1; level <= deepestLevel; ++level) {
    const double reach = kReach_samples * tiling.metrics(level).meanEdge.radians() / tileCells;
    // Reaches halve from level to level: this one and all deeper ones together are less than two of it.
    const double widest_m = 2.0 * reach * body.ellipsoid.semiMajorAxis_m();
    if (widest_m <= limit_m) plan.reaches[static_cast<std::size_t>(level)] = reach;
  }
  return plan;
}

}  // namespace tellurion::pyramid
