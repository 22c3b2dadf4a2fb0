#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/failure.h"
#include "raster/raster.h"

class GDALDataset;

/// The rules under which this room uses GDAL: quiet, local, bounded. No other room sees GDAL.
namespace tellurion::raster {

/// While it lives, GDAL's messages on this thread are collected instead of printed. One thread only.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  /// A failure with GDAL's last error message in brackets, if there was one.
  io::Failure failure(io::Failure::Code code, std::string what, std::string where) const;
  bool failed() const { return !lastError_.empty(); }
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  static void collect(int severity, int number, const char* text);
  std::string lastError_;
  std::vector<std::string> warnings_;
};

/// Closing may complain, so a dataset ends under a GdalMessages too.
struct CloseDataset {
  void operator()(GDALDataset* dataset) const;
};
using DatasetPtr = std::unique_ptr<GDALDataset, CloseDataset>;

/// Opens a plain local file for reading: no /vsi path, no URL, only drivers of a list that follow no references, and no
/// raster whose files lie outside its folder, but for a mosaic of `sourcesAnywhere` (virtual_raster.h). What GDAL warns
/// of is added to `warnings`.
io::Result<DatasetPtr> gdalOpen(const std::string& path, std::vector<std::string>& warnings,
                                bool sourcesAnywhere = false);

/// The same for shapes: Shapefile, GeoJSON, GeoPackage, FlatGeobuf and KML.
io::Result<DatasetPtr> gdalOpenVector(const std::string& path);

/// The same for a table of text, parted by commas, semicolons or tabs. A .prj beside it says where it lies.
io::Result<DatasetPtr> gdalOpenTable(const std::string& path);

/// A dataset in memory, and GDAL's name for the memory. Move-only.
class MemoryDataset {
 public:
  MemoryDataset(DatasetPtr dataset, std::string name);
  MemoryDataset(MemoryDataset&&) noexcept;
  MemoryDataset& operator=(MemoryDataset&&) = delete;
  ~MemoryDataset();
  GDALDataset& operator*() const { return *dataset_; }

 private:
  DatasetPtr dataset_;
  std::string name_;
};

/// Opens a TIFF, PNG or GIF that lies in memory, which must outlive the result; nothing beside it is looked for. It
/// must have the size that is stated. Ends under a GdalMessages as other datasets do.
io::Result<MemoryDataset> gdalOpenBytes(std::span<const std::byte> bytes, int width, int height);

/// The names of all files that a raster is read from, side files included, as GDAL lists them; sorted.
std::vector<std::string> filesOf(GDALDataset& dataset);

/// A float32 TIFF of one band without georeference; NaN is its NODATA value.
io::Result<void> gdalWriteFloatTiff(const std::string& path, const Raster<float>& values);

}  // namespace tellurion::raster
