#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raster/band_levels.h"
#include "raster/raster.h"

namespace tellurion::raster {

/// The bands of a dataset that hold a picture, as 8-bit colour and coverage. One thread only; borrows the dataset. The
/// rules on which bands, their scaling and coverage are RasterFile's.
class ColourBands {
 public:
  static io::Result<ColourBands> open(GDALDataset& dataset, const std::string& path,
                                      const std::optional<double>& nodata, std::vector<std::string>& warnings);

  const std::vector<BandLevel>& levels() const { return levels_; }
  io::Result<void> read(const Window& window, Rgba8* block);

 private:
  void setPalette(GDALRasterBand& band);
  io::Result<void> findScale(GDALDataset& dataset, std::vector<std::string>& warnings);
  io::Result<std::vector<double>> sparseSample();
  io::Result<void> readPlain(const BandLevel& level, const Window& window, Rgba8* block);
  io::Result<void> readScaled(const BandLevel& level, const Window& window, Rgba8* block);
  io::Result<void> applyMask(const BandLevel& level, const Window& window, Rgba8* block);
  void applyNoData(const Window& window, Rgba8* block) const;

  std::string path_;
  std::vector<BandLevel> levels_;
  std::vector<Rgba8> palette_;       ///< empty: none
  std::vector<NoDataValue> nodata_;  ///< one a band, or empty
  bool plain_ = true;                ///< stored bytes are colours, or indices of the palette
  double black_ = 0.0;               ///< stored value that becomes 0 where not plain
  double white_ = 255.0;             ///< stored value that becomes 255
  std::vector<double> values_;
  std::vector<std::uint8_t> mask_;
};

}  // namespace tellurion::raster
