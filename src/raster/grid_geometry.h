#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "raster/image_grid.h"
#include "raster/placement.h"
#include "raster/pool.h"
#include "raster/projection.h"
#include "tiling/tiling.h"

namespace tellurion::raster {

inline constexpr int kMaxImageSide = 4096;  ///< pixels of an image of a grid

struct GridImageIdHash {
  std::size_t operator()(const GridImageId& id) const noexcept;
};

/// Places in the plane of a grid.
struct PlanePlaces {
  std::vector<double> x;          ///< units of the plane; not finite where the plane has no such place
  std::vector<double> y;          ///< beyond the last latitude of Mercator: beyond its edge
  std::vector<double> narrowing;  ///< cosine of the latitude
  void resize(std::size_t count);
};

/// The images of one level that may exist, as one picture: pixel (0, 0) is the first of the first of them.
struct GridWindow {
  double left = 0.0;  ///< x and y of its outer upper left corner
  double top = 0.0;
  double period = 0.0;  ///< columns after which the map begins again; 0: never
  double turn = 0.0;    ///< the same in units of the plane
  GridTopology topology;
  int imageColumns = 0;
  int imageRows = 0;
};

/// How a place is read for samples of one spacing.
struct GridFit {
  int level = -1;       ///< the coarsest whose pixels are no larger than a sample, else the finest; -1: none
  double width = 0.0;   ///< of the sample in pixels of the level
  double height = 0.0;  ///< likewise
  bool isMean = false;  ///< of the pixels in that square; else bilinear between four
};

/// Where the images of a GridService lie, and which of them a tile is made of. A level, and with it a sample, depends
/// on the place and on the level of the tile alone, so neighbours agree. Thread-safe.
///
/// Two grids are not read to the letter, so that no tile needs more than some hundred images. Near the poles of a map
/// of longitude and latitude pixels are ever narrower: where more than 16 of them are in a sample, a coarser level is
/// read. And samples more than 8 times larger than the coarsest pixels there are have no data, unless that level has
/// but few images.
class GridGeometry {
 public:
  /// Fails on sizes that make no sense, and on a reference that PROJ does not know. Levels of more than 2^30 pixels a
  /// side are left out.
  static io::Result<std::shared_ptr<const GridGeometry>> make(const GridService& service);
  GridGeometry(const GridGeometry&) = delete;
  GridGeometry& operator=(const GridGeometry&) = delete;

  int levels() const { return static_cast<int>(windows_.size()); }
  const GridWindow& window(int level) const { return windows_[static_cast<std::size_t>(level)]; }
  const GridLevel& level(int level) const { return levels_[static_cast<std::size_t>(level)]; }
  /// x after which the plane begins again; 0: never.
  double turn() const { return turn_; }

  void places(std::span<const geo::Direction> directions, PlanePlaces& out) const;

  /// spacing: of the tile's samples (sampleSpacing).
  GridFit fit(geo::Angle spacing, tiling::Scheme scheme, double narrowing) const;
  /// The same on a given level, for a place that finer levels do not hold.
  GridFit fitOn(int level, geo::Angle spacing, tiling::Scheme scheme, double narrowing) const;
  /// The larger side of a pixel, as an angle.
  geo::Angle pixelSide(int level, double narrowing) const;

  /// Pixel coordinates in the window of a level, rounded to 2^-20 pixel: whole pixels may be added to them without
  /// loss.
  struct Pixel {
    double col;
    double row;
  };
  Pixel pixel(int level, double x, double y) const;
  /// Whether the service's bounds hold a place.
  bool isInBounds(double x, double y) const;

  /// The image at a column and row of images of a window.
  GridImageId imageAt(int level, int column, int row) const;
  /// Those of the next coarser level that lie under an image.
  std::vector<GridImageId> imagesUnder(const GridImageId& id) const;

 private:
  explicit GridGeometry(const GridService& service);
  io::Result<void> addLevel(const GridLevel& level);
  io::Result<void> measureOther();
  io::Result<Projection> projection() const;
  void findBounds();

  MapPlane plane_;
  geo::Body body_;
  geo::GeoRect bounds_;
  double turn_ = 0.0;
  double radiansPerUnit_ = 0.0;                                  ///< along a meridian; of Mercator on the equator
  double south_ = 0.0, north_ = 0.0, west_ = 0.0, width_ = 0.0;  ///< the bounds, in units of the plane
  std::vector<GridLevel> levels_;
  std::vector<GridWindow> windows_;
  mutable Pool<Projection> projections_;
};

/// The distance between the samples of a tile, on the unit sphere, that decides how fine a grid is read for them. A
/// tenth more than the mean one, so that a grid of 90 degrees an image fits a face of a cube.
geo::Angle sampleSpacing(const tiling::Tiling& tiling, int level, int cells);

}  // namespace tellurion::raster
