// Tables and layers of points as they come: what is read, what is left out, what is refused and how.
#include "raster/point_layer.h"

#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <fstream>
#include <limits>

#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::ScratchFolder;
using namespace std::string_literals;

struct Read {
  std::optional<io::Failure> failure;
  PointLayerInfo info;
  std::vector<geo::Geodetic> points;

  std::string warnings() const {
    std::string all;
    for (const std::string& warning : info.warnings)
      all += warning + "\n";
    return all;
  }
};

Read read(const std::string& path, const PointOptions& points = {}, const RasterOptions& options = {}) {
  Read result;
  auto info = readPoints(path, options, points, [&](const geo::Direction& place, float height_m) -> io::Result<void> {
    geo::Geodetic at = geo::geodeticFromDirection(place);
    at.height_m = static_cast<double>(height_m);
    result.points.push_back(at);
    return {};
  });
  if (info) {
    result.info = std::move(*info);
  } else {
    result.failure = info.error();
  }
  return result;
}

class PointLayer : public ::testing::Test {
 protected:
  std::string table(const std::string& text, const std::string& name = "points.csv") const {
    std::ofstream(folder_.file(name), std::ios::binary) << text;
    return folder_.file(name);
  }
  void expectFirst(const Read& result, double lat, double lon, double height_m) const {
    ASSERT_FALSE(result.failure.has_value()) << io::describe(*result.failure);
    ASSERT_FALSE(result.points.empty());
    EXPECT_NEAR(result.points[0].lat.degrees(), lat, 1e-6);
    EXPECT_NEAR(result.points[0].lon.degrees(), lon, 1e-6);
    EXPECT_NEAR(result.points[0].height_m, height_m, 1e-3);
  }
  void expectRefused(const Read& result, const std::string& says) const {
    ASSERT_TRUE(result.failure.has_value());
    EXPECT_NE(result.failure->message.find(says), std::string::npos) << io::describe(*result.failure);
    EXPECT_FALSE(result.failure->where.empty());
  }
  /// A GeoPackage of one point.
  std::string package(OGRwkbGeometryType type, const char* reference, double x, double y, double z, double height) {
    GDALAllRegister();
    const std::string path = folder_.file("points.gpkg");
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GPKG");
    const std::unique_ptr<GDALDataset> dataset(driver->Create(path.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    OGRSpatialReference spatial;
    spatial.SetFromUserInput(reference);
    spatial.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    OGRLayer* layer = dataset->CreateLayer("points", &spatial, type, nullptr);
    OGRFieldDefn field("Elev", OFTReal);
    EXPECT_EQ(layer->CreateField(&field), OGRERR_NONE);
    const std::unique_ptr<OGRFeature> feature(OGRFeature::CreateFeature(layer->GetLayerDefn()));
    feature->SetField(0, height);
    OGRPoint point(x, y, z);
    feature->SetGeometry(&point);
    EXPECT_EQ(layer->CreateFeature(feature.get()), OGRERR_NONE);
    return path;
  }
  ScratchFolder folder_;
};

TEST_F(PointLayer, TablesAreReadWhateverPartsTheirColumns) {
  for (const std::string& text : {"lon,lat,height\n7.5,46.25,1234.5\n"s, "Latitude;Longitude;ELEV\n46.25;7.5;1234.5\n"s,
                                  "id\tx\ty\tz\n1\t7.5\t46.25\t1234.5\n"s,
                                  "\"name\",\"lon\",\"lat\",\"alt\"\n\"a, b\nc\",\"7.5\",\" 46.25 \",\"1234.5\"\r\n"s,
                                  "lon,lat,height\n367.5,46.25,+1.2345e3\n"s}) {
    const Read result = read(table(text));
    expectFirst(result, 46.25, 7.5, 1234.5);
    EXPECT_NE(result.warnings().find("no spatial reference"), std::string::npos);
  }
}

TEST_F(PointLayer, WhatIsNoPointIsLeftOutAndCounted) {
  const Read result =
      read(table("lon,lat,height\n7.5,46.25,1234.5\n7.5,,3\n7.5,46,nan\n7.5,46,inf\n,,\nx,y,z\n7.5,46,1e300\n"
                 "1e300,46,3\n7.5,90.5,3\n7.5,46,-9999\n7,46,20\n"),
           {}, {.nodata = -9999, .body = std::nullopt, .sourcesAnywhere = false, .cacheBytes = 0});
  expectFirst(result, 46.25, 7.5, 1234.5);
  EXPECT_EQ(result.points.size(), 2u);
  const std::string warnings = result.warnings();
  EXPECT_NE(warnings.find("5 of its points lack a number"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("2 of its points lie beyond"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("1 of its points have heights"), std::string::npos) << warnings;
  EXPECT_NE(warnings.find("1 of its points have the height that means no data"), std::string::npos) << warnings;
}

TEST_F(PointLayer, WhereNothingIsLeftTheMostFrequentReasonIsTold) {
  expectRefused(read(table("lon,lat,height\n")), "holds no points");
  expectRefused(read(table("lon,lat,height\na,b,c\n7,46,nan\n1e300,46,3\n")), "2 lack a number");
  expectRefused(read(table("x,y,z\n500000,5100000,3\n500001,5100000,3\n7,46,nan\n")), "--points-srs");
  expectRefused(read(table("a,b,c\n1,2,3\n")), "do not say where the place is");
  expectRefused(read(table("lon,lat,depth\n1,2,3\n")), "do not say where the height is");
  expectRefused(read(folder_.file("none.csv")), "no such file");
}

TEST_F(PointLayer, HostileTablesAreReadOrRefused) {
  std::string wide = "lon,lat,height";
  std::string row = "7.5,46.25,1234.5";
  for (int i = 0; i < 8000; ++i) {
    wide += ",c" + std::to_string(i);
    row += ",1";
  }
  expectFirst(read(table(wide + "\n" + row + "\n")), 46.25, 7.5, 1234.5);
  const std::string junk(20000, '"');
  const std::string null = "lon,lat,height\n7.5,46\0.25,3\n7.5,46.25,1234.5\n"s;
  for (const std::string& text : {""s, "\n\n\n"s, junk, std::string(4096, '\0'), null, "lon,lat,height\n\"7.5,46.25,3"s,
                                  "lon,lat,height\n"s + std::string(1000000, '7') + ",46,3\n", "\xff\xfe\x00l\x00o"s,
                                  "lon;lat,height\n7.5,46.25;3\n"s, "lon,lon,lat,lat,height,height\n1\n"s,
                                  "WKT,height\n\"POLYGON((0 0,0 1,1 1,0 0))\",3\n"s, "WKT,height\nPOINT(,3\n"s}) {
    const Read result = read(table(text));
    EXPECT_FALSE(result.failure && result.failure->message.empty());
    for (const geo::Geodetic& point : result.points)
      EXPECT_TRUE(std::isfinite(point.lat.radians()) && std::isfinite(point.height_m));
  }
}

TEST_F(PointLayer, ColumnsThatAreNamedAreTaken) {
  const std::string path = table("lon,lat,height,E,N,Z2\n1,2,3,7.5,46.25,1234.5\n");
  expectFirst(read(path, {.columns = {"e", "n", "z2"}, .reference = {}}), 46.25, 7.5, 1234.5);
  expectRefused(read(path, {.columns = {"e", "n", "depth"}, .reference = {}}), "no column 'depth'");
  expectRefused(read(path, {.columns = {"height"}, .reference = {}}), "name three columns");
  const std::string geometry = package(wkbPoint25D, "EPSG:4326", 7.5, 46.25, 10.0, 20.0);
  expectFirst(read(geometry), 46.25, 7.5, 10.0);
  expectFirst(read(geometry, {.columns = {"elev"}, .reference = {}}), 46.25, 7.5, 20.0);
}

TEST_F(PointLayer, AZThatIsZeroEverywhereIsNoHeightWhereAColumnHasOne) {
  const Read result = read(package(wkbPoint25D, "EPSG:4326", 7.5, 46.25, 0.0, 20.0));
  expectFirst(result, 46.25, 7.5, 20.0);
  EXPECT_NE(result.warnings().find("z is 0 everywhere"), std::string::npos);
  std::filesystem::remove(folder_.file("points.gpkg"));
  expectFirst(read(package(wkbPoint, "EPSG:4326", 7.5, 46.25, 0.0, 20.0)), 46.25, 7.5, 20.0);
}

// The corner of a zone: 500 km east of its central meridian, on the equator, is that meridian there.
TEST_F(PointLayer, CoordinatesOfAMapAreTakenToItsPlaces) {
  const std::string path = table("lon,lat,x,y,z\n1,2,500000,0,30\n1,2,500000,0,30\n");
  for (const bool isBeside : {false, true}) {
    if (isBeside) {
      OGRSpatialReference zone;
      zone.SetFromUserInput("EPSG:32632");
      char* wkt = nullptr;
      zone.exportToWkt(&wkt);
      std::ofstream(folder_.file("points.prj")) << wkt;
      CPLFree(wkt);
    }
    const Read result = read(path, {.columns = {}, .reference = isBeside ? "" : "EPSG:32632"});
    expectFirst(result, 0.0, 9.0, 30.0);
    EXPECT_EQ(result.warnings(), "");
    EXPECT_EQ(result.info.files.size(), isBeside ? 2u : 1u);
  }
  expectFirst(read(package(wkbPoint25D, "EPSG:32632", 500000.0, 0.0, 30.0, 0.0)), 0.0, 9.0, 30.0);
  expectRefused(read(table("lon,lat,z\n9,0,30\n"), {.columns = {}, .reference = "EPSG:32632"}), "where the place is");
  const Read unknown = read(path, {.columns = {}, .reference = "EPSG:1"});
  ASSERT_TRUE(unknown.failure.has_value());
  EXPECT_NE(unknown.failure->message.find("is no spatial reference"), std::string::npos);
}

TEST_F(PointLayer, OfAnOldDatumIsShiftedAsARasterIs) {
  // The European Datum of 1950 lies some 100 m from WGS 84 in the middle of Europe.
  const Read result = read(table("lon,lat,z\n9,50,30\n"), {.columns = {}, .reference = "EPSG:4230"});
  ASSERT_FALSE(result.failure.has_value()) << io::describe(*result.failure);
  const double off_m = (result.points[0].lat.degrees() - 50.0) * 111000.0;
  EXPECT_LT(off_m, -50.0);
  EXPECT_GT(off_m, -150.0);
}

TEST_F(PointLayer, ATableThatIsAGridStaysARaster) {
  std::string grid = "lon,lat,height\n";
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 5; ++column)
      grid += std::to_string(7 + column) + "," + std::to_string(50 - row) + "," + std::to_string(row * column) + "\n";
  }
  EXPECT_FALSE(isPointFile(table(grid, "grid.csv"), {}));
  EXPECT_TRUE(isPointFile(table(grid, "grid.csv"), {.columns = {"height"}, .reference = {}}));
  EXPECT_TRUE(isPointFile(table("lon,lat,height\n7.1,46,1\n8.3,45.2,2\n7.7,47.3,3\n"), {}));
  EXPECT_TRUE(isPointFile(package(wkbPoint25D, "EPSG:4326", 7.5, 46.25, 10.0, 20.0), {}));
  EXPECT_FALSE(isPointFile(folder_.file("none.tif"), {}));
}

TEST_F(PointLayer, LinesAndSeveralLayersAreRefused) {
  const std::string lines =
      table(R"({"type":"Feature","properties":{"z":1},"geometry":{"type":"LineString","coordinates":[[0,0],[1,1]]}})",
            "lines.geojson");
  ASSERT_TRUE(read(lines).failure.has_value());
  const std::string mixed = table(
      R"({"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"z":1},"geometry":{"type":"Point","coordinates":[0,0]}},
{"type":"Feature","properties":{"z":1},"geometry":{"type":"LineString","coordinates":[[0,0],[1,1]]}}]})",
      "mixed.geojson");
  expectRefused(read(mixed), "lines or areas");
}

}  // namespace
}  // namespace tellurion::raster
