#include <gtest/gtest.h>

#include <cmath>

#include "pyramid/colour_query.h"
#include "pyramid/export_fixture_test.h"
#include "pyramid/verify.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Kind;
using tiling::Scheme;

/// MBTiles and GeoPackages as inputs: what GDAL wrote, and what an export did.
class ImportTest : public ExportSuite {
 protected:
  void expectSound(const std::filesystem::path& database) {
    const auto report = verifyPyramid(database);
    ASSERT_TRUE(report.has_value()) << io::describe(report.error());
    EXPECT_TRUE(report->sound()) << report->faults.front();
  }
  /// What GDAL's own driver makes of a raster.
  std::filesystem::path writtenByGdal(const std::filesystem::path& input, const char* driver, const std::string& name) {
    const Opened source = opened(input);
    const Opened copy(GetGDALDriverManager()->GetDriverByName(driver)->CreateCopy(
        (folder_ / name).c_str(), source.get(), FALSE, nullptr, nullptr, nullptr));
    EXPECT_NE(copy, nullptr) << CPLGetLastErrorMsg();
    return folder_ / name;
  }
  void expectSoftColours(const std::filesystem::path& database, int tolerance) {
    const auto query = ColourQuery::create(*PyramidReader::open(database));
    std::size_t compared = 0;
    for (double lat = -83.7; lat < 84.0; lat += 4.1) {
      for (double lon = -179.3; lon < 180.0; lon += 5.3) {
        if (std::hypot(lat, lon - 60.0) < 14.0) continue;
        const auto answer = *query->at(geo::directionFromDegrees(lat, lon));
        ASSERT_TRUE(answer.has_value()) << lat << " " << lon;
        const raster::Rgba8 expected = softColour(lat, lon);
        EXPECT_NEAR(int{answer->colour.r}, int{expected.r}, tolerance) << lat << " " << lon;
        EXPECT_NEAR(int{answer->colour.g}, int{expected.g}, tolerance) << lat << " " << lon;
        EXPECT_NEAR(int{answer->colour.b}, int{expected.b}, tolerance) << lat << " " << lon;
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000u);
    const auto hole = *query->at(geo::directionFromDegrees(0.0, 60.0));
    EXPECT_FALSE(hole.has_value());
  }
};

TEST_P(ImportTest, ExportedPicturesComeBack) {
  const auto database = colourDatabase();
  for (const auto& [format, name] :
       {std::pair{ExportFormat::mbtiles, "c.mbtiles"}, std::pair{ExportFormat::geopackage, "c.gpkg"}}) {
    SCOPED_TRACE(name);
    exported({.input = database, .output = folder_ / name, .format = format});
    const auto back = built(std::string(name) + ".tdb", (folder_ / name).string(), Kind::imagery);
    expectSound(back);
    expectSoftColours(back, 6);
  }
}

TEST_P(ImportTest, ExportedHeightsComeBack) {
  const auto database = hillyDatabase();
  exported({.input = database, .output = folder_ / "h.gpkg", .format = ExportFormat::geopackage});
  const auto back = built("back.tdb", (folder_ / "h.gpkg").string(), Kind::elevation);
  expectSound(back);
  const auto first = HeightQuery::create(*PyramidReader::open(database));
  const auto second = HeightQuery::create(*PyramidReader::open(back));
  for (double lat = -89.7; lat < 90.0; lat += 4.1) {
    for (double lon = -179.3; lon < 180.0; lon += 5.3) {
      const auto before = *first->at(geo::directionFromDegrees(lat, lon));
      const auto after = *second->at(geo::directionFromDegrees(lat, lon));
      ASSERT_TRUE(before && after) << lat << " " << lon;
      EXPECT_NEAR(before->height_m, after->height_m, 40.0) << lat << " " << lon;  // read bilinearly three times
    }
  }
}

TEST_P(ImportTest, FilesOfGdalAreRead) {
  writeColour(folder_ / "colour.tif", degreesGrid(-180, -90, 180, 90, 720, 360),
              [](int c, int r) { return softColour(89.75 - 0.5 * r, -179.75 + 0.5 * c); });
  const auto package = writtenByGdal(folder_ / "colour.tif", "GPKG", "gdal.gpkg");
  const auto fromPackage = built("package.tdb", package.string(), Kind::imagery);
  expectSound(fromPackage);
  expectSoftColours(fromPackage, 8);  // JPEG is what GDAL takes by itself
  // 16-bit heights, which GDAL stores as PNG in a tiled gridded coverage.
  const auto heights = writtenByGdal(writeHillyGlobe(folder_ / "hills.tif"), "GPKG", "hills.gpkg");
  const auto fromHeights = built("heights.tdb", heights.string(), Kind::elevation);
  expectSound(fromHeights);
  const auto query = HeightQuery::create(*PyramidReader::open(fromHeights));
  const Grid input = readGrid(folder_ / "hills.tif");
  for (double lat = -88.0; lat < 89.0; lat += 7.3)
    for (double lon = -178.0; lon < 179.0; lon += 7.1)
      EXPECT_NEAR((*query->at(geo::directionFromDegrees(lat, lon)))->height_m, input.bilinear(lat, lon), 40.0);
}

INSTANTIATE_TEST_SUITE_P(AllTilings, ImportTest, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
