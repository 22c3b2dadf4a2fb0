#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>

#include "pyramid/colour_query.h"
#include "pyramid/export_fixture_test.h"
#include "raster/codec.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::Rgba8;
using tiling::Scheme;

constexpr double kEarthRadius_m = 6378137.0;  // of EPSG:3857

class ExportTiles : public ExportSuite {};

double latitudeOfMercator(double y_m) {
  return (2.0 * std::atan(std::exp(y_m / kEarthRadius_m)) - geo::kPi / 2.0) * 180.0 / geo::kPi;
}

TEST_P(ExportTiles, MbtilesAreTheQuerysColoursInMercator) {
  const auto database = colourDatabase();
  const ExportReport report =
      exported({.input = database, .output = folder_ / "map.mbtiles", .format = ExportFormat::mbtiles});
  EXPECT_EQ(report.minZoom, 0);
  EXPECT_GE(report.maxZoom, 2);
  const Opened dataset = opened(folder_ / "map.mbtiles");
  ASSERT_NE(dataset, nullptr);
  ASSERT_EQ(dataset->GetRasterCount(), 4);
  EXPECT_EQ(dataset->GetRasterXSize(), 256 << report.maxZoom);
  EXPECT_EQ(std::string(dataset->GetSpatialRef()->GetAuthorityCode(nullptr)), "3857");
  const auto t = transformOf(*dataset);
  std::array<std::vector<double>, 4> bands;
  for (int band = 1; band <= 4; ++band)
    bands[static_cast<std::size_t>(band - 1)] = bandOf(*dataset, band);
  const auto width = static_cast<std::size_t>(dataset->GetRasterXSize());
  std::size_t compared = 0;
  for (std::size_t i = 0; i < bands[0].size(); i += 97) {
    const double lon = (t[0] + (static_cast<double>(i % width) + 0.5) * t[1]) / kEarthRadius_m * 180.0 / geo::kPi;
    const double lat = latitudeOfMercator(t[3] + (static_cast<double>(i / width) + 0.5) * t[5]);
    const double toHole = std::hypot(lat, lon - 60.0);
    if (std::abs(toHole - 12.0) < 2.0) continue;  // its rim is bilinear
    const Rgba8 expected = softColour(lat, lon);
    ASSERT_EQ(bands[3][i], expected.a) << lat << " " << lon;
    if (expected.a == 0) continue;
    ++compared;
    ASSERT_NEAR(bands[0][i], expected.r, 5) << lat << " " << lon;
    ASSERT_NEAR(bands[1][i], expected.g, 5) << lat << " " << lon;
    ASSERT_NEAR(bands[2][i], expected.b, 5) << lat << " " << lon;
  }
  EXPECT_GT(compared, 5000u);
}

raster::Raster<Rgba8> picture(const std::filesystem::path& path) {
  const std::string bytes = bytesOf(path);
  auto decoded = raster::decodeImage(std::as_bytes(std::span(bytes)), 256, 256);
  EXPECT_TRUE(decoded.has_value()) << path;
  return decoded ? *decoded : raster::Raster<Rgba8>(256, 256);
}

TEST_P(ExportTiles, GeodeticFoldersAreTheColoursOfThePlaces) {
  const auto database = colourDatabase();
  const ExportReport report = exported({.input = database,
                                        .output = folder_ / "tiles",
                                        .format = ExportFormat::xyz,
                                        .maxLevel = 1,
                                        .scheme = MapScheme::geodetic});
  EXPECT_EQ(report.tiles, 2u + 8u);
  for (int zoom = 0; zoom <= 1; ++zoom) {
    const double side = 180.0 / (1 << zoom);
    for (int x = 0; x < 2 << zoom; ++x) {
      for (int y = 0; y < 1 << zoom; ++y) {
        const auto pixels = picture(
            folder_ / ("tiles/" + std::to_string(zoom) + "/" + std::to_string(x) + "/" + std::to_string(y) + ".png"));
        for (int r = 5; r < 256; r += 41) {
          for (int c = 5; c < 256; c += 41) {
            const double lat = 90.0 - side * (y + (r + 0.5) / 256);
            const double lon = -180.0 + side * (x + (c + 0.5) / 256);
            if (std::abs(std::hypot(lat, lon - 60.0) - 12.0) < 2.0) continue;
            const Rgba8 expected = softColour(lat, lon);
            EXPECT_EQ(int{pixels.at(c, r).a}, int{expected.a}) << lat << " " << lon;
            if (expected.a == 0) continue;
            EXPECT_NEAR(int{pixels.at(c, r).r}, int{expected.r}, 6) << lat << " " << lon;
            EXPECT_NEAR(int{pixels.at(c, r).b}, int{expected.b}, 6) << lat << " " << lon;
          }
        }
      }
    }
  }
  EXPECT_NE(bytesOf(folder_ / "tiles/tiles.json").find("\"maxzoom\": 1"), std::string::npos);
}

TEST_P(ExportTiles, OnlyTilesThatHoldDataAreWritten) {
  const auto database = dateLineDatabase();
  exported({.input = database, .output = folder_ / "tiles", .format = ExportFormat::xyz, .minLevel = 3, .maxLevel = 5});
  std::set<std::string> columns;
  for (const auto& column : std::filesystem::directory_iterator(folder_ / "tiles/5"))
    columns.insert(column.path().filename().string());
  EXPECT_EQ(columns, (std::set<std::string>{"0", "31"}));  // 11.25 degrees each, on both sides of the date line
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tiles/2"));
  // With a region on one side only.
  exported({.input = database,
            .output = folder_ / "east",
            .format = ExportFormat::xyz,
            .minLevel = 5,
            .maxLevel = 5,
            .region = geo::GeoRect::fromDegrees(-10, -179, 10, -175)});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "east/5/0"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "east/5/31"));
}

TEST_P(ExportTiles, FoldersOfOthersAreNotReplaced) {
  const auto database = dateLineDatabase();
  const ExportOptions options{
      .input = database, .output = folder_ / "tiles", .format = ExportFormat::xyz, .maxLevel = 3, .replace = true};
  std::filesystem::create_directories(folder_ / "tiles");
  std::ofstream(folder_ / "tiles/thesis.txt") << "years of work";
  const auto refused = exportPyramid(options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(bytesOf(folder_ / "tiles/thesis.txt"), "years of work");
  std::filesystem::remove(folder_ / "tiles/thesis.txt");
  exported(options);
  std::ofstream(folder_ / "tiles/old.txt") << "of the export before";
  exported(options);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tiles/old.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "tiles/tiles.json"));
  // A folder of that name that no export left.
  std::filesystem::create_directories(folder_ / "tiles.part");
  EXPECT_FALSE(exportPyramid(options).has_value());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "tiles.part"));
}

TEST_P(ExportTiles, HeightsAndOtherBodiesAreRefused) {
  const auto heights =
      exportPyramid({.input = hillyDatabase(), .output = folder_ / "h.mbtiles", .format = ExportFormat::mbtiles});
  ASSERT_FALSE(heights.has_value());
  EXPECT_NE(heights.error().message.find("geotiff"), std::string::npos);
  writeColour(folder_ / "mars.tif", degreesGrid(-180, -90, 180, 90, 90, 45), [](int, int) {
    return Rgba8{200, 100, 50, 255};
  });
  const auto mars = built("mars.tdb", (folder_ / "mars.tif").string(), raster::Kind::imagery, geo::mars());
  const auto mercator =
      exportPyramid({.input = mars, .output = folder_ / "m.mbtiles", .format = ExportFormat::mbtiles});
  ASSERT_FALSE(mercator.has_value());
  EXPECT_NE(mercator.error().message.find("geodetic"), std::string::npos);
  exported({.input = mars, .output = folder_ / "m", .format = ExportFormat::xyz, .scheme = MapScheme::geodetic});
}

TEST_P(ExportTiles, APlanetIsNotMagnifiedToItsFinestPartUnasked) {
  BuildOptions options;
  options.output = folder_ / "inset.tdb";
  options.kind = raster::Kind::imagery;
  options.scheme = GetParam();
  writeColour(folder_ / "globe.tif", degreesGrid(-180, -90, 180, 90, 90, 45), [](int, int) {
    return Rgba8{20, 40, 90, 255};
  });
  writeColour(folder_ / "inset.tif", degreesGrid(10, 45, 10.02, 45.02, 200, 200), [](int, int) {
    return Rgba8{200, 180, 60, 255};
  });
  options.inputs = {(folder_ / "globe.tif").string(), (folder_ / "inset.tif").string()};
  ASSERT_NE(builtPyramid(options), nullptr);
  for (const ExportFormat format : {ExportFormat::mbtiles, ExportFormat::xyz, ExportFormat::cog}) {
    ExportOptions all{.input = options.output, .output = folder_ / std::string(nameOf(format)), .format = format};
    const auto refused = exportPyramid(all);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().message.find("--region"), std::string::npos) << refused.error().message;
    all.maxLevel = 0;
    exported(all);
    all.replace = true;
    all.maxLevel = std::nullopt;
    all.region = geo::GeoRect::fromDegrees(45.001, 10.001, 45.019, 10.019);
    exported(all);
  }
}

INSTANTIATE_TEST_SUITE_P(AllTilings, ExportTiles, ::testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& test) { return std::string(tiling::nameOf(test.param)); });

}  // namespace
}  // namespace tellurion::pyramid::testing
