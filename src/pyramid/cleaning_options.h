#pragma once

#include <string>
#include <vector>

namespace tellurion::pyramid {

/// How the inputs of an imagery build meet where more is wanted than the later over the earlier.
struct CleaningOptions {
  /// Each input's colours are moved to those of the inputs above it, by what they share (raster/colour_match.h). Not
  /// with an append.
  bool matchColours = false;
  /// Over how many metres an input gives way to what is below it, at the border of its data and at its holes, and
  /// outside of cutAt; 0: not at all.
  double feather_m = 0.0;
  /// Files of polygons (coastlines) that all inputs but the first of a database are cut at.
  std::vector<std::string> cutAt;
  /// Clouds in an input, found by comparison with the inputs below it (raster/cloud_mask.h), give way to those. Not
  /// with an append.
  bool clouds = false;

  bool asksForAnything() const { return matchColours || feather_m > 0.0 || !cutAt.empty() || clouds; }
};

}  // namespace tellurion::pyramid
