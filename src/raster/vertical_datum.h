#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "geo/body.h"
#include "geo/geo_rect.h"
#include "io/failure.h"

namespace tellurion::raster {

/// Where the zero of a vertical datum lies: its height above the body's ellipsoid, place by place (for mean sea level
/// the geoid's undulation). What it is named by:
///   egm96, egm2008   Earth's geoids of these names
///   EPSG:CODE        a vertical reference, by PROJ's best operation to WGS 84 whose grids are installed
///   anything else    a file with a grid of metres above the ellipsoid that GDAL reads (.gtx, .tif, .byn, ...), of any
///                    body: an areoid too. Interpolated bilinearly.
/// One thread only; move-only. A value depends on the place alone. Never goes to the network.
class VerticalDatum {
 public:
  /// `area`: where it is wanted; operations differ from country to country. Fails with notFound where a grid or a file
  /// is not there, and says which; with invalidArgument where `name` is no vertical reference, or one of another body.
  static io::Result<VerticalDatum> open(const std::string& name, const geo::Body& body, const geo::GeoRect& area);
  VerticalDatum(VerticalDatum&&) noexcept;
  VerticalDatum& operator=(VerticalDatum&&) noexcept;
  ~VerticalDatum();

  /// Metres above the ellipsoid, one for each place, into `out` of the same size. Fails where the grid has no value.
  io::Result<void> heightsOfZero(std::span<const geo::Direction> places, std::span<double> out);

  /// The grids that it is read from.
  const std::vector<std::string>& files() const;

 private:
  class Grid;
  class File;
  class Operation;
  explicit VerticalDatum(std::unique_ptr<Grid> grid);
  std::unique_ptr<Grid> grid_;
};

}  // namespace tellurion::raster
