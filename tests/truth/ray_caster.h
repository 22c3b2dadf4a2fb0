#pragma once

#include <string>
#include <vector>

#include "geo/ellipsoid.h"

// The truth that pictures are measured against: rays marched through the source rasters themselves. It shares nothing
// with the program but the names of its positions: no tiles, no GPU, rasters read whole by GDAL, GeographicLib for the
// ellipsoid.
namespace tellurion::truth {

/// Longitude-latitude rasters held whole in memory, later ones over earlier ones, bilinear between sample centres.
class SourceSurface {
 public:
  /// Throws std::runtime_error where a file cannot be read: tests end there.
  SourceSurface(const std::vector<std::string>& rasterPaths, const geo::Ellipsoid& ellipsoid);

  /// Metres above the ellipsoid; 0 where no raster has data. Degrees.
  double height_m(double lat, double lon) const;
  double lowest_m() const { return lowest_; }
  double highest_m() const { return highest_; }
  /// The smallest distance between two samples of any raster, north to south.
  double spacing_m() const { return spacing_; }
  const geo::Ellipsoid& ellipsoid() const { return ellipsoid_; }

 private:
  struct Layer {
    int width = 0;
    int height = 0;
    double west = 0;   ///< of the first sample's centre, degrees
    double north = 0;  ///< likewise
    double stepX = 0;
    double stepY = 0;  ///< positive southwards
    bool wraps = false;
    double noData = 0;
    bool hasNoData = false;
    std::vector<float> samples;

    bool sample(double lat, double lon, double& value) const;
    double at(int col, int row) const;
  };
  static Layer read(const std::string& path);

  std::vector<Layer> layers_;
  geo::Ellipsoid ellipsoid_;
  double lowest_ = 0;
  double highest_ = 0;
  double spacing_ = 0;
};

/// Distance in metres from the origin to where a ray (unit direction) first meets the surface; NaN when it never does.
/// Features narrower than a fifth of the surface's spacing may be stepped over.
double distanceAlong(const SourceSurface& surface, const geo::Ray& ray);

}  // namespace tellurion::truth
