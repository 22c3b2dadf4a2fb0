#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "raster/raster_fixture_test.h"

// Opening: what is refused and how it says so, each real raster, each hostile file.
namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;
using testing::makeRaster;
using testing::openOrDie;
using testing::ScratchFolder;

const fs::path kShared = TELLURION_SHARED_DATA_DIR;

void expectFailure(const std::string& path, Kind kind, const char* part) {
  const auto file = RasterFile::open(path, kind);
  ASSERT_FALSE(file) << path;
  EXPECT_EQ(file.error().where, path);
  EXPECT_NE(file.error().message.find(part), std::string::npos) << file.error().message;
}

/// Reads a grid of places over the whole raster, as points and as means.
io::Result<int> sampleAll(RasterFile& file, Kind kind) {
  const geo::GeoRect b = file.info().bounds;
  std::vector<geo::Direction> directions;
  for (int i = 0; i < 40 * 40; ++i) {
    const geo::Angle lat = b.south + (b.north - b.south) * ((i / 40 + 0.5) / 40.0);
    const geo::Angle lon = b.west + b.width * ((i % 40 + 0.5) / 40.0);
    directions.push_back(geo::directionFromLatLon(lat, lon));
  }
  int known = 0;
  for (const geo::Angle footprint : {geo::Angle(), (b.north - b.south) / 40.0}) {
    if (kind == Kind::elevation) {
      std::vector<float> heights(directions.size(), kNoData);
      if (auto done = file.sampleHeights(directions, footprint, heights); !done) return tl::unexpected(done.error());
      known += static_cast<int>(std::ranges::count_if(heights, [](float h) { return !isNoData(h); }));
    } else {
      std::vector<Rgba8> colours(directions.size());
      if (auto done = file.sampleColours(directions, footprint, colours); !done) return tl::unexpected(done.error());
      known += static_cast<int>(std::ranges::count_if(colours, [](Rgba8 c) { return c.a != 0; }));
    }
  }
  return known;
}

TEST(RasterOpen, OnlyPlainLocalFiles) {
  const ScratchFolder folder;
  expectFailure(folder.file("none.tif"), Kind::elevation, "no such file");
  expectFailure("", Kind::elevation, "not the name of a local file");
  expectFailure("/vsicurl/http://127.0.0.1/a.tif", Kind::elevation, "not the name of a local file");
  expectFailure("http://127.0.0.1/a.tif", Kind::elevation, "not the name of a local file");
  expectFailure("<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"/>", Kind::elevation, "not the name of a local file");
  std::ofstream(folder.file("a.vrt"))
      << "<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"><GeoTransform>0,1,0,0,0,-1</GeoTransform>"
         "<VRTRasterBand dataType=\"Byte\" band=\"1\"><SimpleSource><SourceFilename>/etc/passwd"
         "</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>";
  expectFailure(folder.file("a.vrt"), Kind::imagery, "VRT");
  std::ofstream(folder.file("a.xml"))
      << "<GDAL_WMS><Service name=\"TMS\"><ServerUrl>http://127.0.0.1:9/</ServerUrl></Service></GDAL_WMS>";
  expectFailure(folder.file("a.xml"), Kind::imagery, "cannot be opened");
  fs::create_directory(folder.file("empty"));
  expectFailure(folder.file("empty"), Kind::imagery, "is a folder");
}

testing::MadeRaster smallGrid() {
  return {.width = 4, .height = 4, .type = GDT_Byte, .transform = {5, 1, 0, 5, 0, -1}, .value = [](int, int, int) {
            return 1.0;
          }};
}

TEST(RasterOpen, WhatAFileNamesIsNotOpened) {
  const ScratchFolder folder;
  makeRaster(folder.file("secret.tif"), smallGrid());
  std::ofstream(folder.file("a.mrf")) << "<MRF_META><CachedSource><Source>" << folder.file("secret.tif")
                                      << "</Source></CachedSource><Raster><Size x=\"4\" y=\"4\" c=\"1\"/><PageSize "
                                         "x=\"4\" y=\"4\" c=\"1\"/></Raster><GeoTags><BoundingBox minx=\"5\" "
                                         "miny=\"1\" maxx=\"9\" maxy=\"5\"/></GeoTags></MRF_META>";
  expectFailure(folder.file("a.mrf"), Kind::imagery, "cannot be opened");
  std::ofstream(folder.file("a.kml")) << "<kml><Document><Region/><NetworkLink><Link><href>secret.tif</href></Link>"
                                         "</NetworkLink><GroundOverlay><Icon><href>secret.tif</href></Icon>"
                                         "</GroundOverlay></Document></kml>";
  expectFailure(folder.file("a.kml"), Kind::imagery, "cannot be opened");
  std::ofstream(folder.file("a.lbl")) << "Object = IsisCube\n  Object = Core\n    ^Core = secret.tif\n    Format = "
                                         "GeoTIFF\n    Group = Dimensions\n      Samples = 4\n      Lines = 4\n      "
                                         "Bands = 1\n    End_Group\n    Group = Pixels\n      Type = UnsignedByte\n "
                                         "     ByteOrder = Lsb\n      Base = 0.0\n      Multiplier = 1.0\n    "
                                         "End_Group\n  End_Object\nEnd_Object\nEnd\n";
  expectFailure(folder.file("a.lbl"), Kind::imagery, "cannot be opened");
}

TEST(RasterOpen, SideFilesStayBesideTheirRaster) {
  const ScratchFolder folder;
  fs::create_directory(folder.file("inner"));
  makeRaster(folder.file("secret.tif"), smallGrid());
  const std::string path = folder.file("inner/a.tif");
  makeRaster(path, smallGrid());
  ASSERT_TRUE(RasterFile::open(path, Kind::imagery));
  std::ofstream(path + ".aux.xml") << "<PAMDataset><Metadata domain=\"OVERVIEWS\"><MDI key=\"OVERVIEW_FILE\">"
                                   << folder.file("secret.tif") << "</MDI></Metadata></PAMDataset>";
  expectFailure(path, Kind::imagery, "outside its own folder");
}

TEST(RasterOpen, ALabelReachesNoFileOutsideItsFolder) {
  const ScratchFolder folder;
  fs::create_directory(folder.file("inner"));
  std::ofstream(folder.file("secret.img")) << std::string(64, 'x');
  const auto label = [](const char* image) {
    return std::string(
               "PDS_VERSION_ID = PDS3\nRECORD_TYPE = FIXED_LENGTH\nRECORD_BYTES = 8\nFILE_RECORDS = 8\n^IMAGE = "
               "\"") +
           image +
           "\"\nOBJECT = IMAGE\n LINES = 8\n LINE_SAMPLES = 8\n SAMPLE_TYPE = UNSIGNED_INTEGER\n SAMPLE_BITS = 8\n "
           "BANDS = 1\nEND_OBJECT = IMAGE\nEND\n";
  };
  std::ofstream(folder.file("inner/near.img")) << std::string(64, 'x');
  std::ofstream(folder.file("inner/near.lbl")) << label("near.img");
  expectFailure(folder.file("inner/near.lbl"), Kind::elevation, "where it lies");  // it opens; it has no place
  std::ofstream(folder.file("inner/far.lbl")) << label("../secret.img");
  expectFailure(folder.file("inner/far.lbl"), Kind::elevation, "outside its own folder");
}

TEST(RasterOpen, ASmallCacheGivesTheSameSamples) {
  const ScratchFolder folder;
  testing::MadeRaster made = smallGrid();
  made.width = made.height = 1500;
  made.type = GDT_Int16;
  made.transform = {5, 0.001, 0, 5, 0, -0.001};
  made.value = [](int, int col, int row) { return (col * 31 + row * 17) % 4001; };
  makeRaster(folder.file("a.tif"), made);
  std::vector<geo::Direction> places;
  for (int i = 0; i < 20000; ++i)
    places.push_back(geo::directionFromDegrees(5.0 - 1.5 * ((i * 7919) % 20000) / 20000.0, 5.0 + 1.5 * i / 20000.0));
  std::vector<float> some(places.size(), -1.0f);
  std::vector<float> all(places.size(), -2.0f);
  auto small = RasterFile::open(folder.file("a.tif"), Kind::elevation, {.nodata = {}, .body = {}, .cacheBytes = 0});
  auto large = openOrDie(folder.file("a.tif"), Kind::elevation);
  ASSERT_TRUE(small);
  ASSERT_TRUE(small->sampleHeights(places, geo::Angle(), some));
  ASSERT_TRUE(large.sampleHeights(places, geo::Angle(), all));
  EXPECT_EQ(some, all);
}

TEST(RasterOpen, WithoutAPlaceThereIsNoRaster) {
  const ScratchFolder folder;
  testing::MadeRaster made{.width = 4, .height = 4, .type = GDT_Byte, .value = [](int, int, int) { return 1.0; }};
  made.reference = "";
  makeRaster(folder.file("none.tif"), made);
  expectFailure(folder.file("none.tif"), Kind::elevation, "where it lies");
  made.transform = {500000, 30, 0, 4000000, 0, -30};
  makeRaster(folder.file("metres.tif"), made);
  expectFailure(folder.file("metres.tif"), Kind::elevation, "no spatial reference");
  made.reference = "EPSG:4326";
  makeRaster(folder.file("lost.tif"), made);
  expectFailure(folder.file("lost.tif"), Kind::elevation, "degrees");
  made.transform = {5, 0, 0, 5, 0, 0};
  makeRaster(folder.file("flat.tif"), made);
  expectFailure(folder.file("flat.tif"), Kind::elevation, "on a line");
  made.transform = {5, std::nan(""), 0, 5, 0, 1};
  makeRaster(folder.file("nan.tif"), made);
  EXPECT_FALSE(RasterFile::open(folder.file("nan.tif"), Kind::elevation));
}

TEST(RasterOpen, KindsThatDoNotFit) {
  const ScratchFolder folder;
  testing::MadeRaster made{.width = 4,
                           .height = 4,
                           .type = GDT_Byte,
                           .bands = 3,
                           .transform = {5, 1, 0, 5, 0, -1},
                           .options = {"PHOTOMETRIC=RGB"},
                           .value = [](int, int, int) { return 1.0; }};
  makeRaster(folder.file("rgb.tif"), made);
  expectFailure(folder.file("rgb.tif"), Kind::elevation, "--kind imagery");
  made.bands = 1;
  made.options = {};
  made.type = GDT_CFloat32;
  makeRaster(folder.file("complex.tif"), made);
  expectFailure(folder.file("complex.tif"), Kind::elevation, "complex");
  expectFailure(folder.file("complex.tif"), Kind::imagery, "complex");
}

TEST(RasterOpen, EachRealRasterOpensOrSaysWhyNot) {
  if (!fs::exists(kShared)) GTEST_SKIP() << kShared << " is not there";
  // Kinds that are refused, and a part of the reason.
  const std::map<std::string, const char*> refused{{"no_crs.tif", "no spatial reference"},
                                                   {"megt90n000cb.img", "label"},
                                                   {"LDEM_4.IMG", "label"},
                                                   {"hirise_cerberus_height_500x500.png", "where it lies"},
                                                   {"hirise_cerberus_ortho_gray.jpg", "where it lies"},
                                                   {"hirise_olympia_undae_height_500x500.png", "where it lies"},
                                                   {"hirise_olympia_undae_ortho_gray.jpg", "where it lies"}};
  int opened = 0;
  for (const char* world : {"earth", "mars", "moon"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kShared / world)) {
      const std::string extension = entry.path().extension().string();
      const bool isRaster =
          std::ranges::count(std::array{".tif", ".tiff", ".hgt", ".jpg", ".png", ".gpkg", ".img", ".IMG", ".LBL"},
                             extension) != 0;
      const bool isBareTile = entry.path().string().find("naturalearth2_tms") != std::string::npos;
      if (!isRaster || isBareTile) continue;
      SCOPED_TRACE(entry.path());
      const auto why = refused.find(entry.path().filename().string());
      for (const Kind kind : {Kind::elevation, Kind::imagery}) {
        auto file = RasterFile::open(entry.path().string(), kind);
        if (why != refused.end()) {
          ASSERT_FALSE(file);
          EXPECT_NE(file.error().message.find(why->second), std::string::npos) << file.error().message;
          continue;
        }
        if (!file) {
          EXPECT_EQ(kind, Kind::elevation);
          EXPECT_NE(file.error().message.find("holds colours"), std::string::npos) << file.error().message;
          continue;
        }
        const auto known = sampleAll(*file, kind);
        ASSERT_TRUE(known) << io::describe(known.error());
        EXPECT_GT(*known, 0);
        ++opened;
      }
    }
  }
  EXPECT_GT(opened, 60);
}

void expectCleanFailureOrData(const std::string& path) {
  for (const Kind kind : {Kind::elevation, Kind::imagery}) {
    auto file = RasterFile::open(path, kind);
    if (!file) {
      EXPECT_FALSE(file.error().message.empty());
      EXPECT_EQ(file.error().where, path);
      continue;
    }
    const auto known = sampleAll(*file, kind);
    if (!known) {
      EXPECT_FALSE(known.error().message.empty());
    }
  }
}

TEST(RasterOpen, EachHostileFileFailsCleanlyOrReads) {
  int seen = 0;
  for (const fs::path& folder : testing::hostileFolders()) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      SCOPED_TRACE(entry.path());
      expectCleanFailureOrData(entry.path().string());
      ++seen;
    }
  }
  EXPECT_GT(seen, 20);
}

TEST(RasterOpen, ATruncatedRasterFailsWhereItIsRead) {
  if (!fs::exists(kShared)) GTEST_SKIP() << kShared << " is not there";
  auto file = RasterFile::open((kShared / "hostile/tiff/srtm_truncated.tif").string(), Kind::elevation);
  if (!file) return;
  const auto known = sampleAll(*file, Kind::elevation);
  ASSERT_FALSE(known);
  EXPECT_NE(known.error().message.find("damaged"), std::string::npos) << known.error().message;
  // And again: a failure does not turn into data.
  EXPECT_FALSE(sampleAll(*file, Kind::elevation));
}

TEST(RasterOpen, PdsHeightsAndTheSameHeightsRolledAgree) {
  if (!fs::exists(kShared)) GTEST_SKIP() << kShared << " is not there";
  auto pds = openOrDie((kShared / "moon/LDEM_4.LBL").string(), Kind::elevation);
  auto tif = openOrDie((kShared / "moon/lola_dem_4ppd.tif").string(), Kind::elevation);
  EXPECT_EQ(pds.info().body, geo::moon());
  // The label's pixel is 7580.84 m wide, rounded to centimetres: 0.0005 pixels over the whole width.
  for (int i = 0; i < 2000; ++i) {
    const double lat = -89.0 + 178.0 * (i * 37 % 2000) / 2000.0;
    const double lon = -180.0 + 0.18 * i;
    const float expected = testing::heightAt(tif, lat, lon);
    ASSERT_NEAR(testing::heightAt(pds, lat, lon), expected, 3.0) << lat << " " << lon;
  }
}

}  // namespace
}  // namespace tellurion::raster
