#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "geo/body.h"
#include "raster/band_levels.h"

namespace tellurion::raster {

/// Heights in metres outside these two are voids that nobody marked. Generous: the extremes are -10,935..8,849 m
/// (Earth), -8,200..21,241 m (Mars), -9,130..10,790 m (Moon).
std::pair<double, double> possibleHeights_m(const geo::Body& body);

/// The band of a dataset that holds elevation, as heights in metres. One thread only; borrows the dataset. The rules on
/// NODATA and units are RasterFile's.
class HeightBand {
 public:
  static io::Result<HeightBand> open(GDALDataset& dataset, const std::string& path, const std::optional<double>& nodata,
                                     const geo::Body& body, std::vector<std::string>& warnings);

  const std::vector<BandLevel>& levels() const { return levels_; }
  double quantum_m() const { return quantum_m_; }
  io::Result<void> read(const Window& window, float* block);
  /// Whether heights that the body cannot have were met, and taken for NODATA.
  bool metImpossibleHeights() const { return metImpossible_; }

 private:
  float heightOf(double stored);

  std::string path_;
  std::vector<BandLevel> levels_;
  std::optional<NoDataValue> nodata_;
  double scale_ = 1.0;
  double offset_m_ = 0.0;
  double quantum_m_ = 0.0;
  double lowest_m_ = 0.0;
  double highest_m_ = 0.0;
  bool metImpossible_ = false;
  std::vector<double> values_;
  std::vector<std::uint8_t> mask_;
};

}  // namespace tellurion::raster
