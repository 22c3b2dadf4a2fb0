#pragma once

#include <array>

#include "geo/body.h"
#include "tiling/tiling.h"

namespace tellurion::pyramid {

/// The limit of a build that fills voids as far as the inputs' depths ask for, metres.
inline constexpr double kFillWithoutLimit_m = 1e9;

/// How far around it data of a level changes what lies beside it and is coarser (void_fill.h), in radians on the unit
/// sphere.
struct FillPlan {
  int fromLevel = 0;      ///< of the coarsest data: only deeper levels change anything
  int baseFromLevel = 0;  ///< the same of the database under an append: down to here its samples change nothing
  std::array<double, tiling::kMaxLevel + 1> reaches{};  ///< 0: this level changes nothing

  double reach(int level) const { return reaches[static_cast<std::size_t>(level)]; }
  /// A tile of the level has to be made where finer data is so near.
  double reachOfTiles(int level) const;
  /// What samples of the level's tiles may depend on lies no farther from them.
  double reachDownTo(int level) const;
};

/// limit_m: no sample depends on another that is farther away; 0: nothing is filled.
FillPlan fillPlan(const tiling::Tiling& tiling, int tileCells, const geo::Body& body, double limit_m, int fromLevel,
                  int deepestLevel);

}  // namespace tellurion::pyramid
