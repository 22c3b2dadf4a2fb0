#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "pyramid/build_plan.h"
#include "raster/colour_match.h"
#include "raster/weight_map.h"

namespace tellurion::pyramid {

class InputSet;

/// How the inputs of an imagery build are laid over each other where CleaningOptions ask for more than one over the
/// other: whose colours are moved, and how much each counts at a place. All found before the first tile, from the
/// inputs at the fineness that it needs (maps take 256 MiB together at most), so that a colour stays a function of its
/// place alone. Of a build of a region (BuildPlan::region) borders are those of the inputs, as if all were built; what
/// is compared is what lies in it. Immutable; threads share it.
class ImageryCleaning {
 public:
  /// Reads the inputs. Null where the options ask for nothing. A stop gives Failure::Code::cancelled. Takes no more
  /// than `memoryBytes`, all of the process; invalidArgument where that is too little for the maps, whose fineness does
  /// not depend on it.
  static io::Result<std::shared_ptr<const ImageryCleaning>> prepare(const BuildPlan& plan, std::uint64_t memoryBytes,
                                                                    std::stop_token stop);

  /// What the maps take while it lives.
  std::uint64_t bytes() const;

  /// What the options come to that may not be meant.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Lays an input's colours, which it changes, over those of the inputs below.
  void lay(int input, std::span<const geo::Direction> places, std::span<raster::Rgba8> own,
           std::span<raster::Rgba8> out) const;

 private:
  class Preparation;
  struct Entry {
    std::optional<raster::ColourMatch> match;  ///< to the colours of what lies above
    std::optional<raster::WeightMap> land;     ///< where it is cut out
    std::optional<raster::WeightMap> rim;      ///< where it gives way to what is below, if there is something
    std::optional<raster::WeightMap> clear;    ///< the same, for clouds
  };
  std::vector<Entry> entries_;
  std::vector<std::string> warnings_;
};

}  // namespace tellurion::pyramid
