#include <gtest/gtest.h>

#include <cmath>

#include "raster/colour.h"
#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using geo::Angle;
using testing::colourAt;
using testing::MadeRaster;
using testing::makeRaster;
using testing::openOrDie;
using testing::ScratchFolder;

/// 20 x 10 pixels of one degree from 10 E, 5 N.
MadeRaster oneDegree(int bands, std::function<double(int, int, int)> value) {
  return {.width = 20,
          .height = 10,
          .type = GDT_Byte,
          .bands = bands,
          .transform = {10, 1, 0, 5, 0, -1},
          .value = std::move(value)};
}

TEST(RasterColours, RedGreenBlueAndAlpha) {
  const ScratchFolder folder;
  auto made = oneDegree(4, [](int band, int col, int) { return band < 4 ? 50.0 * band : col < 10 ? 255.0 : 0.0; });
  made.options = {"PHOTOMETRIC=RGB", "ALPHA=YES"};
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 15.0), (Rgba8{50, 100, 150, 255}));
  EXPECT_EQ(colourAt(file, 0.0, 25.0).a, 0);
  EXPECT_EQ(colourAt(file, 0.0, 25.0, {}, {1, 2, 3, 4}), (Rgba8{1, 2, 3, 4}));
  EXPECT_EQ(colourAt(file, 0.0, 19.99), (Rgba8{50, 100, 150, 255}));
  EXPECT_EQ(colourAt(file, 0.0, 20.01).a, 0);
  // The mean over a square that is half covered lends its colour at half strength.
  const Rgba8 half = colourAt(file, 0.0, 20.0, Angle::degrees(4));
  EXPECT_EQ(half.r, 50);
  EXPECT_NEAR(half.a, 128, 1);
}

TEST(RasterColours, BandsAreFoundByMeaning) {
  const ScratchFolder folder;
  auto made = oneDegree(3, [](int band, int, int) { return 50.0 * band; });
  made.tune = [](GDALDataset& d) {
    d.GetRasterBand(1)->SetColorInterpretation(GCI_BlueBand);
    d.GetRasterBand(2)->SetColorInterpretation(GCI_GreenBand);
    d.GetRasterBand(3)->SetColorInterpretation(GCI_RedBand);
  };
  makeRaster(folder.file("bgr.tif"), made);
  auto file = openOrDie(folder.file("bgr.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 15.0), (Rgba8{150, 100, 50, 255}));
}

TEST(RasterColours, GreyPaletteAndManyBands) {
  const ScratchFolder folder;
  makeRaster(folder.file("grey.tif"), oneDegree(1, [](int, int, int) { return 77.0; }));
  auto grey = openOrDie(folder.file("grey.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(grey, 0.0, 15.0), (Rgba8{77, 77, 77, 255}));

  auto made = oneDegree(1, [](int, int col, int) { return col < 10 ? 3.0 : 4.0; });
  made.tune = [](GDALDataset& d) {
    GDALColorTable table;
    const GDALColorEntry three{10, 20, 30, 255};
    const GDALColorEntry four{200, 100, 50, 255};
    table.SetColorEntry(3, &three);
    table.SetColorEntry(4, &four);
    d.GetRasterBand(1)->SetColorTable(&table);
  };
  makeRaster(folder.file("palette.tif"), made);
  auto palette = openOrDie(folder.file("palette.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(palette, 0.0, 15.0), (Rgba8{10, 20, 30, 255}));
  EXPECT_EQ(colourAt(palette, 0.0, 25.0), (Rgba8{200, 100, 50, 255}));

  auto six = oneDegree(6, [](int band, int, int) { return 30.0 * band; });
  six.options = {"PHOTOMETRIC=MINISBLACK"};
  makeRaster(folder.file("six.tif"), six);
  auto many = openOrDie(folder.file("six.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(many, 0.0, 15.0), (Rgba8{30, 60, 90, 255}));
  EXPECT_EQ(many.info().warnings.size(), 1u);
}

TEST(RasterColours, NoDataNeedsAllBands) {
  const ScratchFolder folder;
  auto made = oneDegree(3, [](int band, int col, int) { return col < 10 ? 0.0 : band == 2 ? 0.0 : 90.0; });
  made.options = {"PHOTOMETRIC=RGB"};
  made.tune = [](GDALDataset& d) {
    for (int b = 1; b <= 3; ++b)
      d.GetRasterBand(b)->SetNoDataValue(0.0);
  };
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 15.0).a, 0);
  EXPECT_EQ(colourAt(file, 0.0, 25.0), (Rgba8{90, 0, 90, 255}));
}

TEST(RasterColours, AMaskIsCoverageWhateverTheColour) {
  const ScratchFolder folder;
  auto made = oneDegree(3, [](int, int, int) { return 0.0; });
  made.options = {"PHOTOMETRIC=RGB"};
  made.tune = [](GDALDataset& d) {
    CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    ASSERT_EQ(d.CreateMaskBand(GMF_PER_DATASET), CE_None);
    std::vector<std::uint8_t> mask(200);
    for (std::size_t i = 0; i < mask.size(); ++i)
      mask[i] = i % 20 < 10 ? 255 : 0;
    ASSERT_EQ(d.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 20, 10, mask.data(), 20, 10, GDT_Byte, 0, 0,
                                                          nullptr),
              CE_None);
  };
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 15.0), (Rgba8{0, 0, 0, 255}));
  EXPECT_EQ(colourAt(file, 0.0, 25.0).a, 0);
}

TEST(RasterColours, SixteenBitsAreScaled) {
  const ScratchFolder folder;
  auto made = oneDegree(3, [](int band, int, int) { return 1000.0 * band; });
  made.type = GDT_UInt16;
  made.options = {"PHOTOMETRIC=RGB", "NBITS=12"};
  makeRaster(folder.file("bits.tif"), made);
  auto bits = openOrDie(folder.file("bits.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(bits, 0.0, 15.0), (Rgba8{62, 125, 187, 255}));  // 255 * 1000 / 4095, ...
  EXPECT_TRUE(bits.info().warnings.empty());

  made.options = {"PHOTOMETRIC=RGB"};
  made.value = [](int, int col, int row) { return 500.0 + 20.0 * col + row; };
  makeRaster(folder.file("wide.tif"), made);
  auto wide = openOrDie(folder.file("wide.tif"), Kind::imagery);
  EXPECT_LT(colourAt(wide, 4.5, 10.5).r, 3);
  EXPECT_GT(colourAt(wide, -4.5, 29.5).r, 252);
  EXPECT_NEAR(colourAt(wide, 0.5, 20.5).r, 255.0 * 204.0 / 389.0, 3);
  EXPECT_EQ(wide.info().warnings.size(), 1u);

  made.type = GDT_Float32;
  made.value = [](int, int col, int) { return col < 10 ? std::nan("") : 0.25; };
  makeRaster(folder.file("float.tif"), made);
  auto flat = openOrDie(folder.file("float.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(flat, 0.0, 15.0).a, 0);
  EXPECT_EQ(colourAt(flat, 0.0, 25.0).a, 255);
}

TEST(RasterColours, BilinearIsOfLight) {
  const ScratchFolder folder;
  makeRaster(folder.file("a.tif"), oneDegree(1, [](int, int col, int) { return col < 10 ? 0.0 : 255.0; }));
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 20.0).g, 188);
  for (int i = 0; i <= 10; ++i) {
    const auto light = static_cast<std::uint16_t>(6553.5 * i);
    EXPECT_NEAR(colourAt(file, 0.0, 19.5 + 0.1 * i).g, srgbFromLinear(light), 1);
  }
  const Rgba8 mean = colourAt(file, 0.0, 20.0, Angle::degrees(6));
  EXPECT_NEAR(mean.b, 188, 1);
  EXPECT_EQ(mean.a, 255);
}

TEST(RasterColours, EveryByteIsKeptWhereAllIsOneColour) {
  const ScratchFolder folder;
  makeRaster(
      folder.file("a.tif"),
      {.width = 256, .height = 4, .type = GDT_Byte, .transform = {0, 1, 0, 8, 0, -4}, .value = [](int, int col, int) {
         return col;
       }});
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  for (int i = 0; i < 256; ++i)
    EXPECT_EQ(colourAt(file, 0.0, i + 0.5).r, i);
}

TEST(RasterColours, PartCoverageIsLaidOverWhatIsThere) {
  const ScratchFolder folder;
  auto made = oneDegree(4, [](int band, int, int) { return band < 4 ? 255.0 : 128.0; });
  made.options = {"PHOTOMETRIC=RGB", "ALPHA=YES"};
  makeRaster(folder.file("a.tif"), made);
  auto file = openOrDie(folder.file("a.tif"), Kind::imagery);
  EXPECT_EQ(colourAt(file, 0.0, 15.0), (Rgba8{255, 255, 255, 128}));
  const Rgba8 blended = colourAt(file, 0.0, 15.0, {}, {0, 0, 0, 255});
  EXPECT_NEAR(blended.r, 188, 1);
  EXPECT_EQ(blended.a, 255);
}

}  // namespace
}  // namespace tellurion::raster
