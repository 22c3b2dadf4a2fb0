#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geo/geodetic.h"
#include "raster/georeference.h"

namespace tellurion::raster {

/// How rows and columns go on beyond their ends.
struct GridTopology {
  int width = 0;
  int height = 0;
  int ring = 0;                ///< columns once around the body; 0: the columns just end
  std::optional<int> topPole;  ///< twice the row coordinate of the pole across row 0 (0: its upper edge, 1: its middle)
  std::optional<int> bottomPole;  ///< the same across the last row

  /// Brings a column and row that lie outside to the pixel that really is there. False: there is none.
  bool resolve(int& col, int& row) const;
  /// The same grid at another resolution (an overview).
  GridTopology scaledTo(int otherWidth, int otherHeight) const;
};

/// Where pixels are wanted, in pixel coordinates: (0, 0) is the outer corner of the first pixel, (0.5, 0.5) its middle.
struct PixelPlaces {
  std::vector<double> col;
  std::vector<double> row;
  std::vector<double>
      width;  ///< sides of the square around a place, in pixels along columns and rows; empty for points
  std::vector<double> height;
};

/// Between directions and pixels. One thread only; move-only.
class Placement {
 public:
  Placement(Georeference georeference, int width, int height);

  const GridTopology& topology() const { return topology_; }
  bool isLonLat() const { return !reference_.projection.has_value(); }
  /// Columns run along parallels and rows along meridians.
  bool isStraightLonLat() const { return straight_ && isLonLat(); }

  /// Fills places.col and row. Outside the raster: anything outside [0, width] x [0, height], or not finite.
  void pixels(std::span<const geo::Direction> directions, PixelPlaces& places) const;
  /// The same from longitudes and latitudes in degrees, in place. Only where isLonLat().
  void pixelsOfLonLat(std::span<double> lon, std::span<double> lat) const { toPixels(lon, lat); }
  /// The same and the sides in pixels of a square of angular side `side`.
  void squares(std::span<const geo::Direction> directions, geo::Angle side, PixelPlaces& places) const;

  /// Columns after which the map begins again; 0 where it does not, or not along columns.
  double period() const { return period_; }
  /// Brings columns of other turns to the one that the raster lies on, and what rounding has put just outside to the
  /// edge.
  void settle(PixelPlaces& places) const;

  /// The place of a pixel coordinate, or nothing where the map has none.
  std::optional<geo::Direction> direction(double col, double row) const;
  /// Longitudes and latitudes in degrees of pixel coordinates, in place; not finite where the map has none.
  void lonLat(std::span<double> col, std::span<double> row) const;

 private:
  void toPixels(std::span<double> lon, std::span<double> lat) const;
  void toEdges(std::span<double> col, std::span<double> row) const;
  double pixelColumn(double col) const;
  void findTopology(int width, int height);

  Georeference reference_;
  std::array<double, 6> inverse_{};  ///< col = i[0] + x i[1] + y i[2], row = i[3] + x i[4] + y i[5]
  bool straight_ = false;            ///< no rotation
  double period_ = 0.0;              ///< columns after which the map begins again; 0 when it does not
  double middleX_ = 0.0;
  GridTopology topology_;
};

}  // namespace tellurion::raster
