#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geo/ellipsoid.h"
#include "truth/pixel_miss.h"

class GDALDataset;

// The truth that pictures are measured against: rays marched through the source rasters themselves. It shares nothing
// with the program but the names of its positions: no tiles, no GPU, rasters read whole by GDAL, GeographicLib for the
// ellipsoid.
namespace tellurion::truth {

/// Rasters held whole in memory, later ones over earlier ones, bilinear between sample centres. Small ones may be in a
/// projection: where a place falls in them is interpolated between places that PROJ was asked for, 1e-3 samples off at
/// the most for rasters of a few kilometres.
class SourceSurface {
 public:
  /// Throws std::runtime_error where a file cannot be read: tests end there.
  SourceSurface(const std::vector<std::string>& rasterPaths, const geo::Ellipsoid& ellipsoid);

  struct Heights {
    double low_m = 0;
    double high_m = 0;
  };

  /// Metres above the ellipsoid; 0 where no raster has data. Degrees. A sample counts for half the way to the next,
  /// with data or without: there one raster ends and the next begins, as a wall.
  double height_m(double lat, double lon) const;
  /// All that the rasters say the ground may be there: samples are points, so between one with data and the next place
  /// without, a whole sample further, nothing tells where the one ends. Anywhere else height_m twice.
  Heights heights(double lat, double lon) const;
  double lowest_m() const { return lowest_; }
  double highest_m() const { return highest_; }
  /// Between the samples of the raster that has data there, north to south; infinite where none has.
  double spacing_m(double lat, double lon) const;
  /// The smallest of any raster.
  double smallestSpacing_m() const { return spacing_; }
  const geo::Ellipsoid& ellipsoid() const { return ellipsoid_; }

 private:
  /// How a place is to a raster's samples: with data on all sides of it, nearest to one that has, or to one that has
  /// not beside one that has, or none of them.
  enum class Cover : std::uint8_t { none, beside, nearest, within };

  /// Where places of a small rectangle fall in a projection, metres.
  struct PlaceTable {
    static constexpr int kCells = 16;
    double west = 0;
    double south = 0;
    double stepLon = 0;
    double stepLat = 0;
    std::array<double, (kCells + 1) * (kCells + 1)> x{};
    std::array<double, (kCells + 1) * (kCells + 1)> y{};

    bool find(double lat, double lon, double& outX, double& outY) const;
  };
  struct Layer {
    int width = 0;
    int height = 0;
    double west = 0;   ///< of the first sample's centre, degrees or, with a projection, metres
    double north = 0;  ///< likewise
    double stepX = 0;
    double stepY = 0;  ///< positive southwards
    double spacing_m = 0;
    bool wraps = false;
    std::optional<PlaceTable> projection;  ///< none: longitude and latitude
    double noData = 0;
    bool hasNoData = false;
    std::vector<float> samples;

    Cover sample(double lat, double lon, double& value) const;
    double at(int col, int row) const;
  };
  static Layer read(const std::string& path, const geo::Ellipsoid& ellipsoid);
  static PlaceTable tableOf(GDALDataset& dataset, const std::array<double, 6>& affine);

  std::vector<Layer> layers_;
  geo::Ellipsoid ellipsoid_;
  double lowest_ = 0;
  double highest_ = 0;
  double spacing_ = 0;
};

/// Distance in metres from the origin to where a ray (unit direction) first meets the surface; NaN when it never does.
/// Features narrower than a fifth of the surface's smallest spacing, or than a fifth of `pixelAngle` (radians) as seen
/// from the origin, may be stepped over, and what rises more steeply than 3 in 1.
double distanceAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle);

/// Both ends of where it may meet the ground that the rasters leave open (SourceSurface::heights).
Seen seenAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle);

/// As distanceAlong where a pixel covers less than a sample: no crest between samples is stepped over that is more than
/// a tenth of a pixel (or 5 cm) high, unless it rises more steeply than 3 in 1. Takes more steps.
double distanceFinelyAlong(const SourceSurface& surface, const geo::Ray& ray, double pixelAngle);

}  // namespace tellurion::truth
