#include <fmt/format.h>
#include <gdal_utils.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "raster/raster_fixture_test.h"

// Resampling against gdalwarp, on real rasters: the same question asked of GDAL itself, without its approximation of
// the transformation (-et 0).
namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using geo::Angle;
using testing::openOrDie;
using testing::ScratchFolder;

std::string shared(const char* name) {
  return (fs::path(TELLURION_SHARED_DATA_DIR) / name).string();
}

/// A grid in longitude and latitude.
struct Grid {
  double west, north, perCol, perRow;
  int width, height;
};

std::string number(double v) {
  return fmt::format("{:.15g}", v);
}

std::vector<float> warped(const std::string& from, const std::string& to, const Grid& g, const char* method,
                          const char* reference) {
  GDALAllRegister();
  std::vector<std::string> words{"-q",
                                 "-overwrite",
                                 "-et",
                                 "0",
                                 "-r",
                                 method,
                                 "-t_srs",
                                 reference,
                                 "-ot",
                                 "Float32",
                                 "-dstnodata",
                                 "nan",
                                 "-ovr",
                                 "NONE",
                                 "-te",
                                 number(g.west),
                                 number(g.north - g.perRow * g.height),
                                 number(g.west + g.perCol * g.width),
                                 number(g.north),
                                 "-ts",
                                 number(g.width),
                                 number(g.height)};
  CPLStringList arguments;
  for (const std::string& word : words)
    arguments.AddString(word.c_str());
  GDALWarpAppOptions* options = GDALWarpAppOptionsNew(arguments.List(), nullptr);
  GDALDatasetH source = GDALOpen(from.c_str(), GA_ReadOnly);
  GDALDatasetH result = GDALWarp(to.c_str(), nullptr, 1, &source, options, nullptr);
  std::vector<float> values(static_cast<std::size_t>(g.width) * static_cast<std::size_t>(g.height), kNoData);
  EXPECT_NE(result, nullptr) << CPLGetLastErrorMsg();
  if (result != nullptr) {
    EXPECT_EQ(GDALRasterIO(GDALGetRasterBand(result, 1), GF_Read, 0, 0, g.width, g.height, values.data(), g.width,
                           g.height, GDT_Float32, 0, 0),
              CE_None);
    GDALClose(result);
  }
  GDALClose(source);
  GDALWarpAppOptionsFree(options);
  return values;
}

std::vector<geo::Direction> middles(const Grid& g) {
  std::vector<geo::Direction> directions;
  for (int row = 0; row < g.height; ++row) {
    for (int col = 0; col < g.width; ++col) {
      directions.push_back(
          geo::directionFromDegrees(g.north - g.perRow * (row + 0.5), g.west + g.perCol * (col + 0.5)));
    }
  }
  return directions;
}

struct Comparison {
  int both = 0;
  int onlyOne = 0;
  double worst = 0.0;
  double mean = 0.0;
};
Comparison compare(const std::vector<float>& ours, const std::vector<float>& theirs) {
  Comparison c;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (isNoData(ours[i]) != isNoData(theirs[i])) ++c.onlyOne;
    if (isNoData(ours[i]) || isNoData(theirs[i])) continue;
    const double difference = std::abs(static_cast<double>(ours[i]) - static_cast<double>(theirs[i]));
    ++c.both;
    c.worst = std::max(c.worst, difference);
    c.mean += difference;
  }
  c.mean /= std::max(1, c.both);
  return c;
}

struct Case {
  const char* file;
  double lat, lon;
  double degrees;  ///< side of the grid to the north
  const char* reference;
  double range;  ///< of the heights there, metres
};
// Longitude and latitude of the raster's own body or datum shifted to WGS 84; UTM; polar stereographic; Lambert.
const Case kCases[] = {
    {"earth/srtm3_everest_N27E086.tif", 27.5, 86.5, 0.3, "EPSG:4326", 6000},
    {"earth/etopo5_dem_10min.tif", 46.0, 8.0, 20.0, "EPSG:4326", 6000},
    {"earth/gabilan_lidar_dem_1m.tif", 35.924, -120.8195, 0.003, "EPSG:4326", 120},
    {"earth/olinda_srtm_dem_90m.tif", -7.995, -34.87, 0.05, "EPSG:4326", 90},
    {"earth/antarctica_dem_polarstereo_2km.tif", -86.5, 121.0, 0.8, "EPSG:4326", 800},
    {"earth/portland_ned_dem_third_as.tif", 45.52, -122.67, 0.02, "EPSG:4326", 330},
    {"earth/geotiff_variants/utm11-2.tiff", 33.76, -117.47, 0.1, "EPSG:4326", 255},
    {"mars/gale_hrsc_dem_660m.tif", -5.4, 137.8, 1.0, "+proj=longlat +R=3396190 +no_defs", 6000},
    {"mars/gale_hirise_dem_1m.tif", -4.6668, 137.3702, 0.002, "+proj=longlat +R=3396190 +no_defs", 40},
};

Grid gridAround(const Case& c, double side, int size) {
  const double perCol = side / std::cos(Angle::degrees(c.lat).radians());
  return {c.lon - 0.5 * size * perCol, c.lat + 0.5 * size * side, perCol, side, size, size};
}

class AgainstGdal : public ::testing::TestWithParam<Case> {};

TEST_P(AgainstGdal, BilinearHeights) {
  const Case& c = GetParam();
  if (!fs::exists(shared(c.file))) GTEST_SKIP() << shared(c.file) << " is not there";
  const ScratchFolder folder;
  auto file = openOrDie(shared(c.file), Kind::elevation);
  const Grid grid = gridAround(c, 0.6 * file.info().finestSpacing.degrees(), 97);
  const auto directions = middles(grid);
  std::vector<float> ours(directions.size(), kNoData);
  ASSERT_TRUE(file.sampleHeights(directions, {}, ours));
  const auto theirs = warped(shared(c.file), folder.file("w.tif"), grid, "bilinear", c.reference);
  const Comparison found = compare(ours, theirs);
  EXPECT_GT(found.both, 3000);
  // GDAL calls a place NODATA by another rule: it differs beside voids only.
  EXPECT_LT(found.onlyOne, found.both / 20);
  EXPECT_LT(found.worst, 2e-5 * c.range);
}

TEST_P(AgainstGdal, MeanHeights) {
  const Case& c = GetParam();
  if (!fs::exists(shared(c.file))) GTEST_SKIP() << shared(c.file) << " is not there";
  const ScratchFolder folder;
  auto file = openOrDie(shared(c.file), Kind::elevation);
  // Squares of about five pixels.
  const double side = 5.0 * file.info().finestSpacing.degrees();
  const Grid grid = gridAround(c, side, std::clamp(static_cast<int>(c.degrees / side), 4, 40));
  const auto directions = middles(grid);
  std::vector<float> ours(directions.size(), kNoData);
  ASSERT_TRUE(file.sampleHeights(directions, Angle::degrees(grid.perRow), ours));
  const auto theirs = warped(shared(c.file), folder.file("w.tif"), grid, "average", c.reference);
  const Comparison found = compare(ours, theirs);
  EXPECT_GT(found.both, 10);
  // GDAL's average takes pixels that a square cuts by other shares, and the squares of a turned map lie turned.
  EXPECT_LT(found.mean, 0.01 * c.range);
  EXPECT_LT(found.worst, 0.08 * c.range);
}

INSTANTIATE_TEST_SUITE_P(RealRasters, AgainstGdal, ::testing::ValuesIn(kCases), [](const auto& param) {
  std::string name = fs::path(param.param.file).stem().string();
  std::ranges::replace_if(
      name, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
});

TEST(AgainstProj, EquidistantCylindricalAsDegreesIsTheSame) {
  const ScratchFolder folder;
  const char* reference = "+proj=eqc +lat_ts=30 +lat_0=10 +lon_0=137 +x_0=1000 +y_0=-2000 +R=3396190 +units=m +no_defs";
  testing::makeRaster(folder.file("e.tif"), {.width = 50,
                                             .height = 40,
                                             .transform = {-9000, 500, 0, 9000, 0, -450},
                                             .reference = reference,
                                             .value = [](int, int col, int row) { return 10.0 * col + row; }});
  auto file = openOrDie(folder.file("e.tif"), Kind::elevation);
  OGRSpatialReference projected;
  projected.SetFromUserInput(reference);
  OGRSpatialReference geographic;
  geographic.CopyGeogCSFrom(&projected);
  geographic.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  auto* transformation = OGRCreateCoordinateTransformation(&projected, &geographic);
  ASSERT_NE(transformation, nullptr);
  for (int i = 0; i < 1000; ++i) {
    const double col = 0.5 + 0.049 * i;
    const double row = 0.5 + 0.039 * (i * 7 % 1000);
    double lon = -9000 + 500 * col;
    double lat = 9000 - 450 * row;
    ASSERT_TRUE(transformation->Transform(1, &lon, &lat));
    ASSERT_NEAR(testing::heightAt(file, lat, lon), 10.0 * (col - 0.5) + row - 0.5, 1e-3);
  }
  OGRCoordinateTransformation::DestroyCT(transformation);
}

TEST(AgainstGdalColours, StoredColoursComeBackAtTheMiddlesOfPixels) {
  const std::string path = shared("earth/everest_landsat7_rgb_30m.tif");
  if (!fs::exists(path)) GTEST_SKIP() << path << " is not there";
  auto file = openOrDie(path, Kind::imagery);
  auto* dataset = GDALDataset::Open(path.c_str(), GDAL_OF_RASTER);
  ASSERT_NE(dataset, nullptr);
  OGRSpatialReference wgs84;
  wgs84.SetFromUserInput("EPSG:4326");
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  auto* transformation = OGRCreateCoordinateTransformation(dataset->GetSpatialRef(), &wgs84);
  for (int i = 0; i < 500; ++i) {
    const int col = i * 37 % 800;
    const int row = i * 53 % 655;
    double lon = 478000 + 30 * (col + 0.5);
    double lat = 3108140 - 30 * (row + 0.5);
    ASSERT_TRUE(transformation->Transform(1, &lon, &lat));
    std::array<std::uint8_t, 3> stored{};
    ASSERT_EQ(dataset->RasterIO(GF_Read, col, row, 1, 1, stored.data(), 1, 1, GDT_Byte, 3, nullptr, 0, 0, 0, nullptr),
              CE_None);
    ASSERT_EQ(testing::colourAt(file, lat, lon), (Rgba8{stored[0], stored[1], stored[2], 255}));
  }
  OGRCoordinateTransformation::DestroyCT(transformation);
  GDALClose(dataset);
}

}  // namespace
}  // namespace tellurion::raster
