#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "pyramid/export.h"
#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {

struct CloseOpened {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Opened = std::unique_ptr<GDALDataset, CloseOpened>;

/// What GDAL makes of an export; a failure fails the test.
inline Opened opened(const std::filesystem::path& path) {
  GDALAllRegister();
  Opened dataset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  EXPECT_NE(dataset, nullptr) << path;
  return dataset;
}

/// A band, whole.
inline std::vector<double> bandOf(GDALDataset& dataset, int band) {
  const int width = dataset.GetRasterXSize();
  const int height = dataset.GetRasterYSize();
  std::vector<double> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  EXPECT_EQ(dataset.GetRasterBand(band)->RasterIO(GF_Read, 0, 0, width, height, values.data(), width, height,
                                                  GDT_Float64, 0, 0, nullptr),
            CE_None);
  return values;
}

inline std::array<double, 6> transformOf(GDALDataset& dataset) {
  std::array<double, 6> transform{};
  EXPECT_EQ(dataset.GetGeoTransform(transform.data()), CE_None);
  return transform;
}

/// A smooth colour of each place, and nothing around 0 N, 60 E.
inline raster::Rgba8 softColour(double lat, double lon) {
  if (std::hypot(lat, lon - 60.0) < 12.0) return {};
  const geo::Vec3 n = geo::directionFromDegrees(lat, lon).n;
  const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(128.0 + 100.0 * v)); };
  return {byte(std::sin(4 * n.x)), byte(n.y), byte(std::cos(5 * n.z)), 255};
}

/// Databases of hills and of colours over the whole globe, and of both over a square on the date line.
class ExportSuite : public ::testing::TestWithParam<tiling::Scheme> {
 protected:
  std::filesystem::path built(const std::string& name, const std::string& input, raster::Kind kind,
                              std::optional<geo::Body> body = std::nullopt) {
    BuildOptions options;
    options.output = folder_ / name;
    options.inputs = {input};
    options.kind = kind;
    options.scheme = GetParam();
    if (kind == raster::Kind::imagery) options.format = TileFormat::png;
    options.body = body;
    EXPECT_NE(builtPyramid(options), nullptr);
    return options.output;
  }
  std::filesystem::path hillyDatabase(std::optional<geo::Body> body = std::nullopt) {
    return built("hills.tdb", writeHillyGlobe(folder_ / "hills.tif"), raster::Kind::elevation, body);
  }
  std::filesystem::path colourDatabase() {
    writeColour(folder_ / "colour.tif", degreesGrid(-180, -90, 180, 90, 720, 360),
                [](int c, int r) { return softColour(89.75 - 0.5 * r, -179.75 + 0.5 * c); });
    return built("colour.tdb", (folder_ / "colour.tif").string(), raster::Kind::imagery);
  }
  /// 20 degrees around 0 N, 180 E, with a hole in the middle.
  std::filesystem::path dateLineDatabase() {
    writeColour(folder_ / "line.tif", degreesGrid(170, -10, 190, 10, 200, 200), [](int c, int r) {
      return std::hypot(c - 100, r - 100) < 40 ? raster::Rgba8{}
                                               : raster::Rgba8{static_cast<std::uint8_t>(c), 200, 30, 255};
    });
    return built("line.tdb", (folder_ / "line.tif").string(), raster::Kind::imagery);
  }
  ExportReport exported(const ExportOptions& options) {
    const auto report = exportPyramid(options);
    EXPECT_TRUE(report.has_value()) << io::describe(report.error());
    std::filesystem::path part = options.output;
    part += ".part";
    EXPECT_FALSE(std::filesystem::exists(part)) << "left behind";
    return report.value_or(ExportReport{});
  }
  TemporaryFolder folder_;
};

}  // namespace tellurion::pyramid::testing
