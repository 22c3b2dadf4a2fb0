#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "geo/body.h"
#include "io/failure.h"
#include "raster/lon_lat_grid.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// Colours of a picture, or of several laid over each other: one for each place, averaged over squares of that angular
/// side; out is laid over.
using ColourSampler = std::function<io::Result<void>(std::span<const geo::Direction>, geo::Angle, std::span<Rgba8>)>;

/// A channel's value as a straight line of another picture's, both 0..255 as they are stored (sRGB).
struct ChannelLine {
  double gain = 1.0;
  double offset = 0.0;
};
using ColourLine = std::array<ChannelLine, 3>;

/// What turns one picture's colours into another's, place by place: a line a channel, bilinear between the cells of a
/// grid. Where the pictures meet in several distant areas each has its own grid, and between them the nearer counts
/// more. Beyond the areas the lines go on as far as the diagonal of the largest one, and fade to no change over two of
/// them. Immutable.
class ColourMatch {
 public:
  /// Areas whose common rectangle one grid of cells covers.
  struct Part {
    LonLatGrid grid;
    std::vector<geo::GeoRect> areas;
    std::vector<ColourLine> lines;
  };
  explicit ColourMatch(std::vector<Part> parts);

  ColourLine at(const geo::Direction& place) const;
  /// The coverage stays.
  Rgba8 apply(const geo::Direction& place, Rgba8 colour) const;

 private:
  std::vector<Part> parts_;
  std::vector<double> reaches_rad_;  ///< of each part, how far its lines go on
};

/// Fits `from` to `to` over `areas`, each group of those that touch (or whose common rectangles do) for itself, at up
/// to 512 x 512 places where both are whole: least squares in each of up to 24 x 24 cells, together with the cells
/// around, the less the farther (so that it varies smoothly, and what is around speaks where a cell has little), drawn
/// towards a gain of 1 where there is no contrast to tell it. Gains stay within 0.4 to 2.5. Places that disagree with
/// the fit (clouds, changes) count less, in three rounds; values of 0 and 255 not at all. Nothing: they have hardly a
/// place in common.
io::Result<std::optional<ColourMatch>> matchColours(const ColourSampler& from, const ColourSampler& to,
                                                    const std::vector<geo::GeoRect>& areas, geo::Angle finestSpacing);

}  // namespace tellurion::raster
