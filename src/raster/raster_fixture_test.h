#pragma once

// Rasters made for one test, and what GDAL says about them.
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geo/geodetic.h"
#include "raster/raster.h"
#include "raster/raster_file.h"

namespace tellurion::raster::testing {

/// A folder that goes away with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test->test_suite_name()) + "_" + test->name();
    std::ranges::replace(name, '/', '_');
    path_ = std::filesystem::temp_directory_path() / ("tellurion_" + std::to_string(::getpid()) + "_" + name);
    std::filesystem::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// Damaged files by format: the project's own small ones, and the larger set where it lies beside the project.
inline std::vector<std::filesystem::path> hostileFolders() {
  std::vector<std::filesystem::path> folders{TELLURION_SOURCE_DIR "/tests/data/hostile"};
  const std::filesystem::path shared = TELLURION_SHARED_DATA_DIR "/hostile";
  if (std::filesystem::exists(shared)) folders.push_back(shared);
  return folders;
}

/// What a made GeoTIFF is like; the rest is said by `tune`.
struct MadeRaster {
  int width = 1;
  int height = 1;
  GDALDataType type = GDT_Float32;
  int bands = 1;
  std::array<double, 6> transform{};    ///< all 0: none
  std::string reference = "EPSG:4326";  ///< empty: none
  std::vector<const char*> options{};
  std::function<double(int band, int col, int row)> value;
  std::function<void(GDALDataset&)> tune{};
};

inline void makeRaster(const std::string& path, const MadeRaster& made) {
  GDALAllRegister();
  CPLStringList options;
  for (const char* option : made.options)
    options.AddString(option);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDataset* dataset = driver->Create(path.c_str(), made.width, made.height, made.bands, made.type, options.List());
  ASSERT_NE(dataset, nullptr);
  auto transform = made.transform;
  if (made.transform != std::array<double, 6>{}) dataset->SetGeoTransform(transform.data());
  if (!made.reference.empty()) {
    OGRSpatialReference reference;
    ASSERT_EQ(reference.SetFromUserInput(made.reference.c_str()), OGRERR_NONE);
    dataset->SetSpatialRef(&reference);
  }
  if (made.tune) made.tune(*dataset);
  std::vector<double> row(static_cast<std::size_t>(made.width));
  for (int b = 1; b <= made.bands; ++b) {
    for (int r = 0; r < made.height; ++r) {
      for (int c = 0; c < made.width; ++c)
        row[static_cast<std::size_t>(c)] = made.value(b, c, r);
      ASSERT_EQ(dataset->GetRasterBand(b)->RasterIO(GF_Write, 0, r, made.width, 1, row.data(), made.width, 1,
                                                    GDT_Float64, 0, 0, nullptr),
                CE_None);
    }
  }
  GDALClose(dataset);
}

inline RasterFile openOrDie(const std::string& path, Kind kind, const RasterOptions& options = {}) {
  auto file = RasterFile::open(path, kind, options);
  if (!file) {
    ADD_FAILURE() << io::describe(file.error());
    std::abort();
  }
  return std::move(*file);
}

inline float heightAt(RasterFile& file, double lat, double lon, geo::Angle footprint = {}) {
  const std::array direction{geo::directionFromDegrees(lat, lon)};
  std::array<float, 1> out{kNoData};
  const auto done = file.sampleHeights(direction, footprint, out);
  EXPECT_TRUE(done) << io::describe(done.error());
  return out[0];
}

inline Rgba8 colourAt(RasterFile& file, double lat, double lon, geo::Angle footprint = {}, Rgba8 below = {}) {
  const std::array direction{geo::directionFromDegrees(lat, lon)};
  std::array out{below};
  const auto done = file.sampleColours(direction, footprint, out);
  EXPECT_TRUE(done) << io::describe(done.error());
  return out[0];
}

}  // namespace tellurion::raster::testing
