#pragma once

#include <functional>
#include <string>

#include "raster/raster.h"
#include "truth/pixel_miss.h"

namespace tellurion::truth {

/// What the pixels of pictures are off, those of sky that is sky not counted.
struct Tally {
  explicit Tally(double tolerance) : tolerance_px(tolerance) {}

  double tolerance_px;  ///< of the pictures
  long pixels = 0;
  long withinTolerance = 0;
  long withinPixel = 0;
  double worst_px = 0;
  int camera = 0;  ///< of the worst, as are the next two
  int col = 0;
  int row = 0;

  void count(double miss_px, int atCamera, int atCol, int atRow);
  void add(const Tally& other);
  /// Of the pixels, those within the tolerance; 0 where there are none: nothing is shown by nothing.
  double share() const;
  /// A pixel's miss that is no more than this need not be known more exactly.
  double enough_px() const;
  std::string told() const;
};

/// Which pixels are compared: column, row, what is drawn there (metres along the ray, NaN is sky).
using Counts = std::function<bool(int col, int row, double drawn_m)>;

/// One surface from one eye, its rays kept. Two threads look at a picture; `surface` is called from both.
class SeenSurface {
 public:
  SeenSurface(SeenAlong surface, const scene::View& view);

  /// On the ray through a pixel's centre.
  const Seen& centre(int col, int row);
  Tally compare(const raster::Raster<float>& drawn, double tolerance_px, int camera, const Counts& counts);

 private:
  SeenAlong surface_;
  scene::View view_;
  raster::Raster<Seen> centres_;
};

}  // namespace tellurion::truth
