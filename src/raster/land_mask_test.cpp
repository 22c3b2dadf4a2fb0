// Coastlines against a point-in-polygon test of GDAL's geometry library, and against what everybody knows of the map.
#include "raster/land_mask.h"

#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include <fstream>

#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::ScratchFolder;

TEST(LandMask, NodesAreInsideAsTheGeometryLibrarySays) {
  const std::string path = TELLURION_SHARED_DATA_DIR "/vectors/gshhg_crude/GSHHS_c_L1.shp";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  // Across the date line: New Zealand, Fiji, the Aleutians.
  const LonLatGrid grid{.bounds = geo::GeoRect::fromDegrees(-50, 160, 60, -160), .width = 160, .height = 440};
  const auto mask = insidePolygons({path}, grid);
  ASSERT_TRUE(mask.has_value()) << io::describe(mask.error());
  GDALAllRegister();
  const std::unique_ptr<GDALDataset> dataset(
      GDALDataset::Open(path.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_NE(dataset, nullptr);
  std::vector<std::unique_ptr<OGRGeometry>> land;
  for (const auto& feature : *dataset->GetLayer(0))
    land.emplace_back(feature->GetGeometryRef()->clone());
  int inside = 0;
  for (int row = 0; row < grid.height; row += 4) {
    const double lat = grid.latitude(row).degrees();
    for (int col = 0; col < grid.width; ++col) {
      const double lon = 160.0 + 40.0 * (col + 0.5) / grid.width;
      bool expected = false;
      for (const double turn : {-360.0, 0.0}) {
        const OGRPoint point(lon + turn, lat);
        for (const auto& polygon : land) {
          OGREnvelope box;
          polygon->getEnvelope(&box);
          const bool near = point.getX() >= box.MinX && point.getX() <= box.MaxX && lat >= box.MinY && lat <= box.MaxY;
          expected = expected || (near && polygon->Contains(&point));
        }
      }
      EXPECT_EQ(mask->at(col, row) == 1, expected) << lat << " " << lon;
      inside += expected ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 100);
}

TEST(LandMask, ProjectedLayersAreTakenToLongitudeAndLatitude) {
  const ScratchFolder folder;
  // 0 to 10 degrees east, 0 to 10 north, in the web's Mercator.
  std::ofstream(folder.file("box.geojson"))
      << R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:3857"}},"features":[)"
      << R"({"type":"Feature","properties":{},"geometry":{"type":"Polygon","coordinates":)"
      << R"([[[0,0],[1113194.9,0],[1113194.9,1118889.97],[0,1118889.97],[0,0]]]}}]})";
  const LonLatGrid grid{.bounds = geo::GeoRect::fromDegrees(-5, -5, 15, 15), .width = 40, .height = 40};
  const auto mask = insidePolygons({folder.file("box.geojson")}, grid);
  ASSERT_TRUE(mask.has_value()) << io::describe(mask.error());
  for (int row = 0; row < 40; ++row) {
    for (int col = 0; col < 40; ++col)
      EXPECT_EQ(mask->at(col, row), row >= 10 && row < 30 && col >= 10 && col < 30 ? 1 : 0) << col << " " << row;
  }
}

TEST(LandMask, MetresWithoutAReferenceAreRefusedAndAStopIsSeen) {
  const ScratchFolder folder;
  const LonLatGrid grid{.bounds = geo::GeoRect::whole(), .width = 8, .height = 4};
  std::ofstream(folder.file("metres.geojson"))
      << R"({"type":"Polygon","coordinates":[[[400000,5000000],[500000,5000000],[500000,5100000],[400000,5000000]]]})";
  const auto metres = insidePolygons({folder.file("metres.geojson")}, grid);
  ASSERT_FALSE(metres.has_value());
  EXPECT_NE(metres.error().message.find("not longitude and latitude"), std::string::npos) << metres.error().message;
  std::ofstream(folder.file("box.geojson")) << R"({"type":"Polygon","coordinates":[[[0,0],[9,0],[9,9],[0,0]]]})";
  std::stop_source stop;
  stop.request_stop();
  const auto stopped = insidePolygons({folder.file("box.geojson")}, grid, stop.get_token());
  ASSERT_FALSE(stopped.has_value());
  EXPECT_EQ(stopped.error().code, io::Failure::Code::cancelled);
}

TEST(LandMask, DamagedAndForeignFilesAreFailures) {
  const ScratchFolder folder;
  const LonLatGrid grid{.bounds = geo::GeoRect::whole(), .width = 8, .height = 4};
  std::ofstream(folder.file("cut.geojson")) << R"({"type":"FeatureCollection","features":[{"type":"Feature","geom)";
  std::ofstream(folder.file("empty.shp"));
  for (const std::string name : {"cut.geojson", "empty.shp", "none.gpkg"})
    EXPECT_FALSE(insidePolygons({folder.file(name)}, grid).has_value()) << name;
  EXPECT_FALSE(insidePolygons({"http://127.0.0.1:1/a.geojson"}, grid).has_value());
  EXPECT_FALSE(insidePolygons({"/vsicurl/http://127.0.0.1:1/a.geojson"}, grid).has_value());
}

}  // namespace
}  // namespace tellurion::raster
