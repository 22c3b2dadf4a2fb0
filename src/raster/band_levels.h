#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "io/failure.h"
#include "raster/pixel_store.h"

class GDALDataset;
class GDALRasterBand;

namespace tellurion::raster {

/// One resolution of the bands that are wanted: the dataset's own, or that of an overview. Borrows the dataset.
struct BandLevel {
  int width = 0;
  int height = 0;
  std::vector<GDALRasterBand*> bands;
  GDALRasterBand* mask = nullptr;  ///< 0 is no data; null: there is none
};

/// Bands (numbers from 1) at full resolution and at the overviews that all of them have, with the first one's mask
/// where that is one of the whole dataset or an alpha band. Fails when a block of the file is too large to be held, or
/// values are complex.
io::Result<std::vector<BandLevel>> bandLevels(GDALDataset& dataset, const std::vector<int>& bands,
                                              const std::string& path);

/// Reads a window of a band, rows PixelStore's block side apart. GDAL's error is in the failure.
io::Result<void> readValues(GDALRasterBand& band, const Window& window, double* block, const std::string& path);
/// Bytes, `spacing` bytes apart.
io::Result<void> readBytes(GDALRasterBand& band, const Window& window, std::uint8_t* block, int spacing,
                           const std::string& path);

/// NODATA as a band means it: the value itself, within the rounding of its type and of its text. NaN never matches.
class NoDataValue {
 public:
  NoDataValue(double value, GDALRasterBand& band);
  bool matches(double stored) const { return stored >= low_ && stored <= high_; }

 private:
  double low_;
  double high_;
};

/// The value given by the caller, else the band's own, else nothing. Fails where the band cannot hold the given value.
io::Result<std::optional<NoDataValue>> noDataOf(GDALRasterBand& band, const std::optional<double>& given,
                                                const std::string& path);

}  // namespace tellurion::raster
