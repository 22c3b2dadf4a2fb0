// Mosaics (VRT): what is read of them, and what is refused.
#include "raster/virtual_raster.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "raster/raster_file.h"
#include "raster/raster_fixture_test.h"

namespace tellurion::raster::testing {
namespace {

/// A grid of one degree a pixel with one source over it all.
std::string mosaic(const std::string& source, const std::string& attributes = R"(relativeToVRT="1")",
                   const std::string& more = "") {
  return fmt::format(
      R"(<VRTDataset rasterXSize="20" rasterYSize="20"><GeoTransform>0,1,0,20,0,-1</GeoTransform>{}
<VRTRasterBand dataType="Int16" band="1"><SimpleSource><SourceFilename {}>{}</SourceFilename><SourceBand>1</SourceBand>
<SrcRect xOff="0" yOff="0" xSize="10" ySize="10"/><DstRect xOff="0" yOff="0" xSize="20" ySize="20"/></SimpleSource>
</VRTRasterBand></VRTDataset>)",
      more, attributes, source);
}

void makeSource(const std::string& path, const std::function<double(int col, int row)>& value) {
  makeRaster(path, {.width = 10,
                    .height = 10,
                    .type = GDT_Int16,
                    .transform = {0, 2, 0, 20, 0, -2},
                    .value = [&](int, int col, int row) { return value(col, row); }});
}

void write(const std::string& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(VirtualRaster, IsReadAsItsSourcesScaled) {
  const ScratchFolder folder;
  makeSource(folder.file("source.tif"), [](int col, int row) { return 100.0 * row + col; });
  write(folder.file("mosaic.vrt"), mosaic("source.tif"));
  auto file = RasterFile::open(folder.file("mosaic.vrt"), Kind::elevation);
  ASSERT_TRUE(file.has_value()) << io::describe(file.error());
  EXPECT_EQ(file->info().width, 20);
  EXPECT_EQ(file->info().files.size(), 2u);
  // The middle of the mosaic's pixel (4, 6), which is the source's (2, 3).
  EXPECT_EQ(heightAt(*file, 13.5, 4.5), 302.0f);
}

TEST(VirtualRaster, MayLieElsewhereThanItsSourcesWhereTheUserNamedIt) {
  const ScratchFolder folder;
  makeSource(folder.file("source.tif"), [](int col, int row) { return 100.0 * row + col; });
  std::filesystem::create_directory(folder.file("below"));
  write(folder.file("below/upwards.vrt"), mosaic("../source.tif"));
  write(folder.file("below/absolute.vrt"), mosaic(folder.file("source.tif"), R"(relativeToVRT="0")"));
  for (const char* name : {"below/upwards.vrt", "below/absolute.vrt"}) {
    RasterOptions named;
    named.sourcesAnywhere = true;
    auto file = RasterFile::open(folder.file(name), Kind::elevation, named);
    ASSERT_TRUE(file.has_value()) << io::describe(file.error());
    EXPECT_EQ(heightAt(*file, 13.5, 4.5), 302.0f) << name;
    const auto unnamed = RasterFile::open(folder.file(name), Kind::elevation);
    ASSERT_FALSE(unnamed.has_value());
    EXPECT_NE(unnamed.error().message.find("outside its own folder"), std::string::npos);
  }
}

TEST(VirtualRaster, OtherThanAPlainMosaicIsRefused) {
  const ScratchFolder folder;
  makeSource(folder.file("source.tif"), [](int, int) { return 1.0; });
  std::filesystem::create_directory(folder.file("below"));
  const std::string path = folder.file("below/mosaic.vrt");
  const auto expectRefused = [&](const std::string& text, const std::string& why) {
    write(path, text);
    RasterOptions named;
    named.sourcesAnywhere = true;
    const auto file = RasterFile::open(path, Kind::elevation, named);
    ASSERT_FALSE(file.has_value()) << text;
    EXPECT_NE(file.error().message.find(why), std::string::npos) << io::describe(file.error());
  };
  expectRefused(mosaic("/dev/zero", R"(relativeToVRT="0")"), "is not there");
  write(folder.file("label.lbl"), "PDS_VERSION_ID = PDS3\r\n^IMAGE = \"../secret.img\"\r\nEND\r\n");
  write(folder.file("database.mbtiles"), std::string("SQLite format 3\0", 16));
  expectRefused(mosaic("../label.lbl"), "a database or a label");
  expectRefused(mosaic("../database.mbtiles"), "a database or a label");
  expectRefused(mosaic("absent.tif"), "is not there");
  expectRefused(mosaic("/vsicurl/http://127.0.0.1:9/a.tif", ""), "not a raster file");
  expectRefused(mosaic("other.vrt"), "not a raster file");
  expectRefused(mosaic("../source.tif", R"(RELATIVETOVRT="1")"), "RELATIVETOVRT");
  expectRefused(mosaic("x", "", R"(<GDALWarpOptions><SourceDataset>/etc/passwd</SourceDataset></GDALWarpOptions>)"),
                "GDALWarpOptions");
  expectRefused(R"(<VRTDataset rasterXSize="2" rasterYSize="2" subClass="VRTWarpedDataset"/>)", "VRTWarpedDataset");
  expectRefused(R"(<VRTDataset rasterXSize="2" rasterYSize="2"><VRTRasterBand dataType="Byte" band="1"
subClass="VRTRawRasterBand"><SourceFilename>/etc/passwd</SourceFilename></VRTRasterBand></VRTDataset>)",
                "VRTRawRasterBand");
  expectRefused(R"(<VRTDataset rasterXSize="2" rasterYSize="2"><VRTRasterBand dataType="Byte" band="1"
subClass="VRTDerivedRasterBand"><PixelFunctionType>f</PixelFunctionType></VRTRasterBand></VRTDataset>)",
                "VRTDerivedRasterBand");
  expectRefused("<VRTDataset rasterXSize=", "");
}

// GDAL may open a source as late as it is read.
TEST(VirtualRaster, OfWhatIsNoRasterHasNoData) {
  const ScratchFolder folder;
  write(folder.file("secret.txt"), "name:password\n");
  write(folder.file("mosaic.vrt"), mosaic("secret.txt"));
  auto file = RasterFile::open(folder.file("mosaic.vrt"), Kind::elevation);
  if (!file) return;
  const auto place = geo::directionFromDegrees(13.5, 4.5);
  float height = kNoData;
  EXPECT_FALSE(file->sampleHeights({&place, 1}, {}, {&height, 1}).has_value());
  EXPECT_TRUE(isNoData(height));
}

// A virtual raster under another name: GDAL itself opens none.
TEST(VirtualRaster, CannotBeASource) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder.file("below"));
  makeSource(folder.file("secret.tif"), [](int, int) { return 7.0; });
  write(folder.file("below/hidden.tif"), mosaic("../secret.tif"));
  write(folder.file("below/mosaic.vrt"), mosaic("hidden.tif"));
  // With its size given, GDAL opens a source when it is read.
  std::string late = mosaic("hidden.tif");
  late.insert(late.find("<SrcRect"), R"(<SourceProperties RasterXSize="10" RasterYSize="10" DataType="Int16"/>)");
  write(folder.file("below/late.vrt"), late);
  for (const char* name : {"below/mosaic.vrt", "below/late.vrt"}) {
    auto file = RasterFile::open(folder.file(name), Kind::elevation);
    if (!file) continue;
    const auto place = geo::directionFromDegrees(13.5, 4.5);
    float height = kNoData;
    EXPECT_FALSE(file->sampleHeights({&place, 1}, {}, {&height, 1}).has_value()) << name;
    EXPECT_TRUE(isNoData(height)) << name;
  }
}

}  // namespace
}  // namespace tellurion::raster::testing
