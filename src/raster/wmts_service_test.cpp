#include "raster/wmts_service.h"

#include <fstream>
#include <iterator>

#include "raster/map_reference.h"
#include "raster/service_fixture_test.h"

namespace tellurion::raster {
namespace {

ServiceLayer entryOf(const std::string& document, const std::string& layer) {
  ServiceLayer entry;
  entry.source = sharedDocument("wmts/" + document);
  entry.layer = layer;
  return entry;
}

TEST(WmtsService, TheStandardsExample) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  ServiceLayer entry = entryOf("wmts_ogc_sample.xml", "BlueMarbleNextGeneration");
  entry.matrixSet = "google3857";
  const GridService keyValue = opened(entry);
  expectSoundGrid(keyValue);
  EXPECT_EQ(keyValue.plane.kind, MapPlane::Kind::webMercator);
  // The sample's well-known set: 156543.0339280410 m a pixel, 256 pixels, from -20037508.3428.
  EXPECT_NEAR(keyValue.levels[0].pixelWidth, 156543.0339280410, 1e-3);
  EXPECT_EQ(keyValue.levels[2].columns, 4);
  EXPECT_EQ(keyValue.levels[0].left, -20037508.3428);
  // Its templates are PNG, which its formats are not: the best is the template's.
  EXPECT_EQ(urlOf(keyValue, 2, 3, 1), "http://www.example.com/wmts/coastlines/2/1/3.png");
  entry.format = "image/jpeg";
  entry.time = "20081024";
  EXPECT_EQ(urlOf(opened(entry), 2, 3, 1),
            "http://www.maps.bob/cgi-bin/MiraMon5_0.cgi?SERVICE=WMTS&REQUEST=GetTile&VERSION=1.0.0&LAYER="
            "BlueMarbleNextGeneration&STYLE=DarkBlue&FORMAT=image/jpeg&TILEMATRIXSET=google3857&Time=20081024&"
            "TILEMATRIX=2&TILEROW=1&TILECOL=3");
  entry.time = "2009";
  EXPECT_NE(refusal(entry).find("has no time 2009; it has 2 times, 20110805 to 20081024"), std::string::npos)
      << refusal(entry);
}

TEST(WmtsService, LongitudeAndLatitudeAreTakenFirst) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  const GridService gibs = opened(entryOf("wmts_nasa_gibs_eosdis.xml", "MODIS_Terra_CorrectedReflectance_TrueColor"));
  expectSoundGrid(gibs);
  EXPECT_EQ(gibs.plane.kind, MapPlane::Kind::lonLat);
  EXPECT_EQ(gibs.levels[0].left, -180.0);
  EXPECT_EQ(gibs.levels[0].top, 90.0);
  EXPECT_NEAR(gibs.levels[0].pixelWidth, 223382916.9173819721 * 0.00028 / 111319.4907932736, 1e-12);
  EXPECT_NE(urlOf(gibs, 1, 2, 1).find("TILEMATRIX=1&TILEROW=1&TILECOL=2"), std::string::npos) << urlOf(gibs, 1, 2, 1);
  const GridService geoserver = opened(entryOf("wmts_geoserver_gwc.xml", "topp:states"));
  expectSoundGrid(geoserver);
  EXPECT_EQ(geoserver.plane.kind, MapPlane::Kind::lonLat);
  EXPECT_EQ(geoserver.levels[0].left, -180.0) << "the corner of EPSG:4326 is latitude first";
  EXPECT_EQ(geoserver.levels[0].top, 90.0);
  EXPECT_NEAR(geoserver.levels[0].pixelWidth, 0.703125, 1e-9);
  const GridLevel& deep = geoserver.levels.back();
  EXPECT_GT(deep.firstColumn, 0) << "limits of the link";
}

TEST(WmtsService, NorthingFirstByProj) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  ServiceLayer entry = entryOf("wmts_linz.xml", "");
  entry.crs = "EPSG:2193";
  const GridService linz = opened(entry);
  expectSoundGrid(linz);
  EXPECT_EQ(linz.plane.kind, MapPlane::Kind::other);
  EXPECT_EQ(linz.levels[0].left, -1000000.0);
  EXPECT_EQ(linz.levels[0].top, 10000000.0);
}

TEST(WmtsService, TemplatesTakeStyleSetAndMatrix) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  const GridService vienna = opened(entryOf("wmts_basemap_at_vienna.xml", "bmapgelaende"));
  expectSoundGrid(vienna);
  EXPECT_EQ(vienna.plane.kind, MapPlane::Kind::webMercator) << "the set is called EPSG:4326, but is not";
  EXPECT_TRUE(urlOf(vienna, 0, 5, 3).ends_with("/bmapgelaende/grau/EPSG:4326/0/3/5.jpeg")) << urlOf(vienna, 0, 5, 3);
  EXPECT_EQ(vienna.attribution, "City of Vienna");
}

TEST(WmtsService, EveryLayerOfEveryDocumentIsSound) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  for (const char* document :
       {"wmts_nasa_gibs_eosdis.xml:55", "wmts_esri_arcgis.xml:1", "wmts_ign_geoportail.xml:1", "wmts_ogc_sample.xml:1",
        "wmts_geoserver_gwc.xml:1", "wmts_basemap_at_vienna.xml:7", "wmts_erdas_apollo.xml:5", "wmts_wgs84_bbox.xml:7",
        "wmts_world_esri_sfs.xml:2", "wmts_linz.xml:1"}) {
    const std::string_view text = document;
    const std::string source = sharedDocument("wmts/" + std::string(text.substr(0, text.find(':'))));
    std::ifstream file(source, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const auto root = parseXml(std::as_bytes(std::span(bytes)), source);
    ASSERT_TRUE(root);
    const auto capabilities = parseWmtsCapabilities(*root, source);
    ASSERT_TRUE(capabilities) << io::describe(capabilities.error());
    EXPECT_EQ(std::to_string(capabilities->layers.size()), text.substr(text.find(':') + 1)) << document;
    for (const WmtsLayer& layer : capabilities->layers) {
      ServiceLayer entry;
      entry.layer = layer.name;
      const auto service =
          wmtsService(*capabilities, entry, Kind::imagery, geo::earth(), "http://127.0.0.1/" + layer.name);
      ASSERT_TRUE(service) << document << ' ' << layer.name << ": " << refusalOf(service);
      expectSoundGrid(*service);
    }
  }
}

TEST(MapReference, NamesOfTheField) {
  for (const char* name :
       {"urn:ogc:def:crs:EPSG:6.18:3:3857", "urn:ogc:def:crs:EPSG::900913", "EPSG:102100", "epsg:3857",
        "http://www.opengis.net/def/crs/EPSG/0/3857", "http://www.opengis.net/gml/srs/epsg.xml#3857",
        "urn:ogc:def:crs:EPSG:6.3:3857", "ESRI:102113", "OSGEO:41001", " EPSG:3785\n"})
    EXPECT_EQ(referenceName(name), "EPSG:3857") << name;
  for (const char* name : {"urn:ogc:def:crs:OGC:1.3:CRS84", "OGC:CRS84", "CRS:84", "CRS84", "urn:ogc:def:crs:CRS::84",
                           "http://www.opengis.net/def/crs/OGC/1.3/CRS84"})
    EXPECT_EQ(referenceName(name), "CRS:84") << name;
  EXPECT_EQ(referenceName("urn:ogc:def:crs:EPSG::25832"), "EPSG:25832");
  EXPECT_EQ(referenceName(""), "");
}

TEST(MapReference, AxesAndUnitsByProj) {
  const auto of = [](const char* name) { return mapReference(name, geo::earth()).value(); };
  EXPECT_TRUE(of("EPSG:4326").northFirst);
  EXPECT_FALSE(of("CRS:84").northFirst);
  EXPECT_FALSE(of("EPSG:25832").northFirst);
  EXPECT_TRUE(of("EPSG:2193").northFirst);
  EXPECT_TRUE(of("EPSG:31467").northFirst) << "Gauss-Krueger: X is north";
  EXPECT_FALSE(of("EPSG:3031").northFirst) << "both axes point north";
  EXPECT_TRUE(of("EPSG:32661").northFirst) << "northing, easting, both south";
  EXPECT_NEAR(of("EPSG:2264").metresPerUnit, 0.3048006096, 1e-9) << "US survey feet";
  EXPECT_NEAR(of("EPSG:4258").metresPerUnit, 111319.4908, 1e-3);
  EXPECT_FALSE(mapReference("EPSG:999999", geo::earth()));
  EXPECT_FALSE(mapReference("EPSG:4978", geo::earth())) << "three axes are no plane";
  EXPECT_EQ(mapReference("IAU2000:49900", geo::mars()).value().plane.kind, MapPlane::Kind::lonLat);
}

}  // namespace
}  // namespace tellurion::raster
