#include <algorithm>
#include <fstream>

#include "raster/grid_geometry.h"
#include "raster/service_fixture_test.h"
#include "raster/service_offers.h"
#include "raster/worldwind_service.h"
#include "raster/xyz_service.h"

namespace tellurion::raster {
namespace {

ServiceLayer templateOf(const std::string& source) {
  ServiceLayer entry;
  entry.source = source;
  return entry;
}

TEST(XyzService, PlacesOfATemplate) {
  const GridService plain = opened(templateOf("https://h/{z}/{x}/{y}.png?key=k"));
  expectSoundGrid(plain);
  EXPECT_EQ(plain.plane.kind, MapPlane::Kind::webMercator);
  EXPECT_EQ(urlOf(plain, 3, 5, 2), "https://h/3/5/2.png?key=k");
  EXPECT_EQ(plain.name.find("=k"), std::string::npos) << plain.name;
  EXPECT_NEAR(plain.levels[0].pixelWidth, 156543.033928041, 1e-6);
  EXPECT_EQ(urlOf(opened(templateOf("https://h/{z}/{x}/{-y}.png")), 3, 5, 2), "https://h/3/5/5.png");
  // Tile 3, 5 of level 3: Bing's own example.
  EXPECT_EQ(urlOf(opened(templateOf("https://{s:012}.h/{q}.jpg")), 3, 3, 5), "https://2.h/213.jpg");
  EXPECT_EQ(urlOf(opened(templateOf("https://{s}.h/{level}/{row}/{col}")), 3, 1, 0), "https://b.h/3/0/1");
  EXPECT_EQ(urlOf(opened(templateOf("/tiles/{z}/{x}/{y}.png")), 1, 0, 1), "file:///tiles/1/0/1.png");
}

TEST(XyzService, GeographicTemplatesHaveTwoRoots) {
  ServiceLayer entry = templateOf("https://h/{z}/{x}/{-y}.png");
  entry.crs = "EPSG:4326";
  entry.tilePixels = 512;
  entry.minLevel = 1;
  entry.maxLevel = 3;
  entry.bounds_degrees = {170.0, -10.0, -170.0, 10.0};  // across the date line: every column
  const GridService service = opened(entry);
  expectSoundGrid(service);
  ASSERT_EQ(service.levels.size(), 3u);
  EXPECT_EQ(service.levels[0].columns, 4);
  EXPECT_EQ(service.levels[0].pixelWidth, 90.0 / 512.0);
  EXPECT_EQ(urlOf(service, 0, 3, 0), "https://h/1/3/1.png");
  EXPECT_EQ(service.levels[2].firstRow, 3);
  EXPECT_EQ(service.levels[2].endRow, 5);
  EXPECT_TRUE(service.bounds.contains(geo::Angle::degrees(0), geo::Angle::degrees(-175)));
  EXPECT_FALSE(service.bounds.contains(geo::Angle::degrees(0), geo::Angle::degrees(0)));
}

TEST(XyzService, Refusals) {
  EXPECT_NE(refusal(templateOf("https://h/{z}/{x}/{yy}.png")).find("'{yy}' is not known"), std::string::npos);
  ServiceLayer entry = templateOf("https://h/{z}/{x}.png");
  entry.type = "xyz";
  EXPECT_NE(refusal(entry).find("needs {x}, {y}"), std::string::npos) << refusal(entry);
  entry.source = "https://h/{z}/{x}/{y}/{t}.png";
  EXPECT_NE(refusal(entry).find("'{t}' is not known"), std::string::npos) << refusal(entry);
  entry.source = "https://me:secret@h/{z}/{x}/{y}.png";
  entry.crs = "EPSG:3031";
  EXPECT_EQ(refusal(entry),
            "https://h/{z}/{x}/{y}.png: tile templates are in EPSG:3857 or EPSG:4326, not in 'EPSG:3031'");
  entry.type = "wnts";
  EXPECT_NE(refusal(entry).find("there is no type 'wnts'; did you mean 'wmts'"), std::string::npos);
  entry.type = "xyz";
  entry.crs.clear();
  for (const auto& [first, last] : {std::pair(-1, 3), std::pair(5, 3), std::pair(0, 99)}) {
    entry.minLevel = first;
    entry.maxLevel = last;
    EXPECT_NE(refusal(entry).find("min_level"), std::string::npos);
  }
}

TEST(WorldWindService, RowsAndColumnsFromTheSouthWest) {
  ServiceLayer entry = templateOf("http://h/tile.aspx");
  entry.type = "worldwind";
  entry.layer = "105";
  EXPECT_NE(refusal(entry).find("level_zero_degrees"), std::string::npos);
  entry.levelZero_degrees = 36.0;
  const GridService service = opened(entry);
  expectSoundGrid(service);
  EXPECT_EQ(service.levels[0].columns, 10);
  EXPECT_EQ(service.levels[0].rows, 5);
  EXPECT_EQ(service.levels[0].top, 90.0);
  // Row 0 from the north is row 4 from the south; a level down there are ten.
  EXPECT_EQ(urlOf(service, 0, 7, 0), "http://h/tile.aspx?T=105&L=0&X=7&Y=4");
  EXPECT_EQ(urlOf(service, 1, 7, 9), "http://h/tile.aspx?T=105&L=1&X=7&Y=0");
  entry.layer.clear();
  entry.source = "http://h/data/";
  entry.format = "image/jpeg";
  entry.levelZero_degrees = 50.0;  // does not divide 180: the tiles reach beyond the pole
  const GridService folder = opened(entry);
  expectSoundGrid(folder);
  EXPECT_EQ(folder.levels[0].rows, 4);
  EXPECT_EQ(folder.levels[0].columns, 8);
  EXPECT_EQ(folder.levels[0].top, 110.0);
  EXPECT_EQ(urlOf(folder, 0, 7, 0), "http://h/data/0/0003/0003_0007.jpg");
  entry.format.clear();
  EXPECT_EQ(urlOf(opened(entry, Kind::elevation), 0, 7, 3), "http://h/data/0/0000/0000_0007.bil");
}

TEST(WorldWindService, ConfigurationsAreEntries) {
  if (!haveSharedDocuments()) GTEST_SKIP() << "no shared data";
  ServiceLayer entry = templateOf(sharedDocument("worldwind_net/Earth_Images.xml"));
  entry.layer = "NLT Landsat7 (Visible Color)";
  const GridService landsat = opened(entry);
  expectSoundGrid(landsat);
  ASSERT_EQ(landsat.levels.size(), 5u);
  EXPECT_EQ(landsat.levels[0].columns, 160);
  EXPECT_EQ(urlOf(landsat, 0, 0, 79), "http://worldwind25.arc.nasa.gov/tile/tile.aspx?T=105&L=0&X=0&Y=0");
  entry.source = sharedDocument("worldwind_net/Earth.xml");
  entry.layer.clear();
  const GridService terrain = opened(entry, Kind::elevation);
  EXPECT_EQ(terrain.levels.size(), 12u);
  EXPECT_EQ(terrain.levels[0].imageWidth, 150);
  EXPECT_EQ(terrain.levels[0].rows, 9);
  EXPECT_NE(refusal(entry).find("of kind imagery; there is none"), std::string::npos) << refusal(entry);
  entry.source = sharedDocument("worldwind_net/Earth_zoomit.xml");
  entry.layer = "West Australia Geology Map (250k)";
  EXPECT_NE(urlOf(opened(entry), 0, 30, 5)
                .find("T=au.westaustralia_geology_250k&version=1&interface=worldwind&firstLevel=5&L=0"),
            std::string::npos)
      << urlOf(opened(entry), 0, 30, 5);
  // World Wind Java: of a WMS.
  io::Resources resources{io::ResourceOptions{}};
  entry = templateOf(sharedDocument("worldwind_java/EarthElevations256.xml"));
  const auto offers = listService(entry, resources);
  ASSERT_TRUE(offers);
  ASSERT_EQ(offers->layers.size(), 1u);
  EXPECT_EQ(offers->layers[0].kind, Kind::elevation);
  EXPECT_EQ(offers->layers[0].entry.type, "wms");
  EXPECT_EQ(offers->layers[0].entry.version, "1.3.0");
  EXPECT_EQ(offers->layers[0].entry.layer, "NASA_SRTM30_900m_Tiled,aster_v2,USGS-NED");
  EXPECT_EQ(offers->layers[0].entry.format, "application/bil16");
}

std::string writeTileMap(const std::string& text) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "tms_service_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "tilemapresource.xml") << text;
  return folder;
}

TEST(TmsService, TheSpecificationsExample) {
  // wiki.osgeo.org/wiki/Tile_Map_Service_Specification: the VMAP0 resource, its folders made relative.
  const std::string folder = writeTileMap(
      "<?xml version='1.0' encoding='UTF-8' ?><TileMap version='1.0.0' tilemapservice='http://tms.osgeo.org/1.0.0'>"
      "<Title>VMAP0 World Map</Title><SRS>EPSG:4326</SRS><BoundingBox minx='-180' miny='-90' maxx='180' maxy='90' />"
      "<Origin x='-180' y='-90' /><TileFormat width='256' height='256' mime-type='image/jpeg' extension='jpg' />"
      "<TileSets profile='global-geodetic'><TileSet href='0' units-per-pixel='0.703125' order='0' />"
      "<TileSet href='http://other/1' units-per-pixel='0.3515625' order='1' />"
      "<TileSet href='2/' units-per-pixel='0.17578125' order='2' /></TileSets></TileMap>");
  const GridService service = opened(templateOf(folder));
  expectSoundGrid(service);
  ASSERT_EQ(service.levels.size(), 3u);
  EXPECT_EQ(service.levels[0].columns, 2);
  EXPECT_EQ(service.levels[0].rows, 1);
  EXPECT_EQ(service.levels[2].rows, 4);
  EXPECT_EQ(service.levels[2].top, 90.0);
  EXPECT_EQ(urlOf(service, 0, 1, 0), "file://" + folder + "/0/1/0.jpg");
  EXPECT_EQ(urlOf(service, 1, 3, 0), "http://other/1/3/1.jpg");
  EXPECT_EQ(urlOf(service, 2, 3, 3), "file://" + folder + "/2/3/0.jpg");
}

TEST(TmsService, BoxesOfOldWritersDoNotCount) {
  // gdal2tiles up to 2.x wrote the box of a Mercator map in degrees, latitude first.
  const std::string folder = writeTileMap(
      "<TileMap><Title>t</Title><SRS>EPSG:900913</SRS>"
      "<BoundingBox minx='-85.05112877980659' miny='-180.0' maxx='85.05112877980659' maxy='180.0'/>"
      "<Origin x='-20037508.342789' y='-20037508.342789'/>"
      "<TileFormat width='256' height='256' mime-type='image/png' extension='png'/><TileSets profile='mercator'>"
      "<TileSet href='1' units-per-pixel='78271.51696402051569' order='1'/></TileSets></TileMap>");
  const GridService service = opened(templateOf(folder));
  ASSERT_EQ(service.levels.size(), 1u);
  EXPECT_EQ(service.levels[0].rows, 2);
  EXPECT_EQ(service.levels[0].endColumn, 2);
  EXPECT_NEAR(service.levels[0].top, 20037508.34, 0.1);
}

TEST(TmsService, BrokenOnesFail) {
  EXPECT_NE(refusal(templateOf(writeTileMap("<TileMap><SRS>EPSG:4326</SRS></TileMap>"))).find("no origin"),
            std::string::npos);
  EXPECT_NE(
      refusal(templateOf(writeTileMap("<TileMap><Origin x='0' y='0'/><TileFormat width='-1' height='1'/></TileMap>")))
          .find("no level"),
      std::string::npos);
  EXPECT_NE(refusal(templateOf(::testing::TempDir())).find("{z}/{x}/{y}.png"), std::string::npos);
  EXPECT_NE(refusal(templateOf("/there/is/no/such.xml")).find("no such file"), std::string::npos)
      << refusal(templateOf("/there/is/no/such.xml"));
}

TEST(Service, whatNoServerCanAnswerIsToldOnce) {
  io::Resources resources{io::ResourceOptions{}};
  const auto message = [&](const std::string& source) {
    const auto offers = listService(templateOf(source), resources);
    return offers ? "no failure" : io::describe(offers.error());
  };
  for (const char* source : {"ftp://h", "http://[::1"}) {
    EXPECT_EQ(message(source).find('\n'), std::string::npos) << message(source);
    EXPECT_TRUE(message(source).starts_with(source)) << message(source);
  }
  EXPECT_NE(message("htp:/x").find("unknown scheme 'htp'"), std::string::npos) << message("htp:/x");
  EXPECT_EQ(message("nofile.xml"), "nofile.xml: no such file");
  EXPECT_NE(message("https://me:secret@h/{z}/{x}/{w}.png").find("https://h/{z}/{x}/{w}.png: '{w}' is not known"),
            std::string::npos);
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "picture.xml").string();
  for (const std::string beginning : {"\xFF\xD8\xFF\xE0", "\x89PNG", "GIF89a"}) {
    std::ofstream(path) << beginning;
    EXPECT_NE(message(path).find("a raster and no service's document"), std::string::npos) << message(path);
  }
}

TEST(Service, tilesThatNoGridTakesAreRefusedWithTheDocument) {
  const auto map = [](int side) {
    return writeTileMap("<TileMap><SRS>EPSG:4326</SRS><Origin x='-180' y='-90'/><TileFormat width='" +
                        std::to_string(side) +
                        "' height='256' mime-type='image/png' extension='png'/><TileSets>"
                        "<TileSet href='0' units-per-pixel='0.7' order='0'/></TileSets></TileMap>");
  };
  EXPECT_TRUE(GridGeometry::make(opened(templateOf(map(kMaxImageSide)))));
  EXPECT_NE(refusal(templateOf(map(kMaxImageSide + 1))).find("impossible size"), std::string::npos);
}

TEST(Service, HostileDocumentsAreRefused) {
  const std::filesystem::path folder = std::filesystem::path(TELLURION_SHARED_DATA_DIR) / "hostile/xml";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared data";
  io::Resources resources{io::ResourceOptions{}};
  const auto offers = listService(templateOf((folder / "wms111_xxe.xml").string()), resources);
  ASSERT_TRUE(offers) << io::describe(offers.error());
  EXPECT_TRUE(std::ranges::any_of(offers->layers, [](const LayerOffer& layer) { return layer.name == "&file;"; }))
      << "the entity stays as it stands";
  ServiceLayer entry = templateOf(sharedDocument("exceptions/wms130_crs_exception_mapserver.xml"));
  EXPECT_NE(refusal(entry).find("the server says: MissingParameterValue: msWMSLoadGetMapParams()"), std::string::npos);
}

TEST(Service, ManyLayersAndReferencesStaySmall) {
  std::string text = "<WMS_Capabilities version='1.3.0'><Capability><Layer>";
  for (int i = 0; i < 6000; ++i)
    text += "<CRS>EPSG:" + std::to_string(20000 + i) + "</CRS>";
  for (int i = 0; i < 2000; ++i)
    text += "<Layer><Name>l" + std::to_string(i) + "</Name></Layer>";
  text += "</Layer></Capability></WMS_Capabilities>";
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "many_layers.xml").string();
  std::ofstream(path) << text;
  io::Resources resources{io::ResourceOptions{}};
  const auto offers = listService(templateOf(path), resources);
  ASSERT_TRUE(offers) << io::describe(offers.error());
  ASSERT_EQ(offers->layers.size(), 2001u);
  EXPECT_EQ(offers->layers[7].crsCount, 6000u);
  EXPECT_LE(offers->layers[7].crs.size(), 64u);
  std::ofstream many(path);
  many << "<WMS_Capabilities version='1.3.0'><Capability>";
  for (int i = 0; i < 20001; ++i)
    many << "<Layer><Name>l</Name></Layer>";
  many << "</Capability></WMS_Capabilities>";
  many.close();
  EXPECT_NE(refusal(templateOf(path)).find("more than 20000 layers"), std::string::npos);
}

}  // namespace
}  // namespace tellurion::raster
