#include <gtest/gtest.h>

#include <cmath>

#include "pyramid/colour_query.h"
#include "pyramid/export_fixture_test.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Kind;
using tiling::Scheme;

class ExportRaster : public ExportSuite {
 protected:
  /// GDAL's heights, pixel by pixel, beside the query's at their centres.
  void expectQuerysHeights(const std::filesystem::path& file, const std::filesystem::path& database,
                           double tolerance_m) {
    const Opened dataset = opened(file);
    ASSERT_NE(dataset, nullptr);
    const auto t = transformOf(*dataset);
    const std::vector<double> heights = bandOf(*dataset, 1);
    const auto query = HeightQuery::create(*PyramidReader::open(database));
    const int width = dataset->GetRasterXSize();
    std::size_t compared = 0;
    for (int r = 0; r < dataset->GetRasterYSize(); r += 7) {
      for (int c = 0; c < width; c += 11) {
        const auto answer = *query->at(geo::directionFromDegrees(t[3] + (r + 0.5) * t[5], t[0] + (c + 0.5) * t[1]));
        const double height =
            heights[static_cast<std::size_t>(r) * static_cast<std::size_t>(width) + static_cast<std::size_t>(c)];
        if (!answer) continue;
        ASSERT_NEAR(height, answer->height_m, tolerance_m) << r << " " << c;
        ++compared;
      }
    }
    EXPECT_GT(compared, 1000u);
  }
};

TEST_P(ExportRaster, HeightsAreTheQuerysInEveryFormat) {
  const auto database = hillyDatabase();
  for (const auto& [format, name] : {std::pair{ExportFormat::geotiff, "h.tif"}, std::pair{ExportFormat::cog, "c.tif"},
                                     std::pair{ExportFormat::geopackage, "h.gpkg"}}) {
    SCOPED_TRACE(name);
    const ExportReport report = exported({.input = database, .output = folder_ / name, .format = format});
    EXPECT_EQ(report.width, 2 * report.height);
    EXPECT_GE(report.width, 720);
    expectQuerysHeights(folder_ / name, database, 1e-3);
    const Opened dataset = opened(folder_ / name);
    EXPECT_EQ(std::string(dataset->GetSpatialRef()->GetAuthorityCode(nullptr)), "4326");
    EXPECT_EQ(dataset->GetRasterBand(1)->GetRasterDataType(), GDT_Float32);
    const bool hasOverviews = dataset->GetRasterBand(1)->GetOverviewCount() > 0;
    EXPECT_EQ(hasOverviews, format != ExportFormat::geotiff);
  }
}

TEST_P(ExportRaster, HeightsAreTheInputs) {
  // Against the raster that the database was built from: two bilinear readings of it, one after the other.
  const auto database = hillyDatabase();
  exported({.input = database, .output = folder_ / "h.tif", .format = ExportFormat::cog});
  const Grid input = readGrid(folder_ / "hills.tif");
  const Grid output = readGrid(folder_ / "h.tif");
  double largest = 0.0;
  for (double lat = -89.0; lat <= 89.0; lat += 3.1)
    for (double lon = -179.0; lon <= 179.0; lon += 2.7)
      largest = std::max(largest, std::abs(input.bilinear(lat, lon) - output.bilinear(lat, lon)));
  EXPECT_LT(largest, 25.0);  // of hills of 8 km, 31 radians a turn
}

TEST_P(ExportRaster, OtherBodiesKeepTheirReference) {
  const auto mars = hillyDatabase(geo::mars());
  for (const char* name : {"mars.tif", "mars.gpkg"}) {
    const bool isPackage = std::string(name).ends_with("gpkg");
    exported({.input = mars,
              .output = folder_ / name,
              .format = isPackage ? ExportFormat::geopackage : ExportFormat::geotiff,
              .maxLevel = 0});
    const Opened dataset = opened(folder_ / name);
    ASSERT_NE(dataset, nullptr);
    ASSERT_NE(dataset->GetSpatialRef(), nullptr);
    EXPECT_DOUBLE_EQ(dataset->GetSpatialRef()->GetSemiMajor(), 3396190.0);
    EXPECT_EQ(dataset->GetSpatialRef()->GetInvFlattening(), 0.0);
  }
}

TEST_P(ExportRaster, ARegionOverTheDateLineAndItsHole) {
  const auto database = dateLineDatabase();
  for (const auto& [format, name] : {std::pair{ExportFormat::geotiff, "l.tif"}, std::pair{ExportFormat::cog, "lc.tif"},
                                     std::pair{ExportFormat::geopackage, "l.gpkg"}}) {
    SCOPED_TRACE(name);
    exported({.input = database,
              .output = folder_ / name,
              .format = format,
              .region = geo::GeoRect::fromDegrees(-5, 175, 5, -175)});
    const Opened dataset = opened(folder_ / name);
    ASSERT_NE(dataset, nullptr);
    ASSERT_EQ(dataset->GetRasterCount(), 4);
    const auto t = transformOf(*dataset);
    EXPECT_NEAR(t[0], 175.0, 0.2);
    EXPECT_NEAR(t[0] + t[1] * dataset->GetRasterXSize(), 185.0, 0.2);
    const std::vector<double> red = bandOf(*dataset, 1);
    const std::vector<double> alpha = bandOf(*dataset, 4);
    const auto query = ColourQuery::create(*PyramidReader::open(database));
    const int width = dataset->GetRasterXSize();
    for (std::size_t i = 0; i < red.size(); i += 3) {
      const double lon = t[0] + (static_cast<double>(i % static_cast<std::size_t>(width)) + 0.5) * t[1];
      const double lat = t[3] + (static_cast<double>(i / static_cast<std::size_t>(width)) + 0.5) * t[5];
      const auto answer = *query->at(geo::directionFromDegrees(lat, lon));
      ASSERT_EQ(alpha[i], answer ? answer->colour.a : 0) << lat << " " << lon;
      if (answer) {
        ASSERT_EQ(red[i], answer->colour.r) << lat << " " << lon;
      }
    }
  }
}

TEST_P(ExportRaster, RefusesWhatItCannotDo) {
  const auto database = dateLineDatabase();
  const auto refused = [&](const ExportOptions& options, const std::string& part) {
    const auto report = exportPyramid(options);
    ASSERT_FALSE(report.has_value());
    EXPECT_NE(io::describe(report.error()).find(part), std::string::npos) << io::describe(report.error());
    EXPECT_FALSE(std::filesystem::exists(folder_ / "x.tif.part"));
  };
  const auto to = [&](const std::string& name) { return ExportOptions{.input = database, .output = folder_ / name}; };
  ExportOptions options = to("x.tif");
  options.region = geo::GeoRect::fromDegrees(-5, 20, 5, 30);
  refused(options, "no data in the region");
  options = to("x.tif");
  options.minLevel = 1;
  refused(options, "one size of pixels");
  options = to("x.tif");
  options.pixels = raster::ImageFormat::jpeg;
  refused(options, "cog");
  refused(to("nowhere/x.tif"), "no such folder");
  options = to("line.tdb");
  options.replace = true;
  refused(options, "the database itself");
  exported(to("x.tif"));
  const std::string before = bytesOf(folder_ / "x.tif");
  refused(to("x.tif"), "--force");
  EXPECT_EQ(bytesOf(folder_ / "x.tif"), before);
  options = to("x.tif");
  options.replace = true;
  options.jobs = 3;
  exported(options);
  EXPECT_EQ(bytesOf(folder_ / "x.tif"), before) << "the same bytes, whoever makes the windows";
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = exportPyramid(options, {}, stop.get_token());
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, io::Failure::Code::cancelled);
  EXPECT_EQ(bytesOf(folder_ / "x.tif"), before);
}

INSTANTIATE_TEST_SUITE_P(AllTilings, ExportRaster, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
