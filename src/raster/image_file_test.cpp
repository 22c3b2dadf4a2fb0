#include "raster/image_file.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using testing::ScratchFolder;

TEST(ImageFile, PngComesBack) {
  const ScratchFolder folder;
  Raster<Rgba8> image(31, 17, Rgba8{1, 2, 3, 255});
  image.at(4, 5) = {200, 100, 50, 20};
  ASSERT_TRUE(writePng(folder.file("a.png"), image));
  const auto back = readImageFile(folder.file("a.png"));
  ASSERT_TRUE(back) << io::describe(back.error());
  EXPECT_EQ(back->samples, image.samples);
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.png.part")));
}

TEST(ImageFile, FloatTiffComesBackThroughGdal) {
  const ScratchFolder folder;
  Raster<float> depth(21, 9, 1.5f);
  depth.at(3, 4) = kNoData;
  depth.at(5, 6) = 123456.789f;
  ASSERT_TRUE(writeTiffFloat(folder.file("d.tif"), depth));
  GDALAllRegister();
  auto* dataset = GDALDataset::Open(folder.file("d.tif").c_str());
  ASSERT_NE(dataset, nullptr);
  EXPECT_EQ(dataset->GetRasterBand(1)->GetRasterDataType(), GDT_Float32);
  Raster<float> back(21, 9);
  ASSERT_EQ(
      dataset->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, 21, 9, back.samples.data(), 21, 9, GDT_Float32, 0, 0, nullptr),
      CE_None);
  EXPECT_TRUE(std::isnan(back.at(3, 4)));
  EXPECT_EQ(back.at(5, 6), 123456.789f);
  EXPECT_EQ(back.at(0, 0), 1.5f);
  EXPECT_TRUE(std::isnan(dataset->GetRasterBand(1)->GetNoDataValue()));
  GDALClose(dataset);
}

TEST(ImageFile, FailuresNameTheFile) {
  const ScratchFolder folder;
  const std::string nowhere = folder.file("no/such/folder/a.png");
  const auto png = writePng(nowhere, Raster<Rgba8>(2, 2));
  ASSERT_FALSE(png);
  EXPECT_EQ(png.error().where, nowhere);
  EXPECT_FALSE(writePng(folder.file("e.png"), {}));
  const auto tiff = writeTiffFloat(folder.file("no/such/d.tif"), Raster<float>(2, 2));
  ASSERT_FALSE(tiff);
  EXPECT_EQ(tiff.error().where, folder.file("no/such/d.tif"));
  EXPECT_EQ(tiff.error().message.find(".part"), std::string::npos) << tiff.error().message;
  EXPECT_FALSE(writeTiffFloat(folder.file("e.tif"), {}));
  EXPECT_FALSE(readImageFile(nowhere));
  std::ofstream(folder.file("text.png")) << "not a picture";
  const auto text = readImageFile(folder.file("text.png"));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().where, folder.file("text.png"));
}

TEST(ImageFile, DeviceIsWrittenToAndNeverReplaced) {
  const ScratchFolder folder;
  const std::filesystem::path device = folder.file("null");  // a link, so that a failing test cannot harm the machine
  std::filesystem::create_symlink("/dev/null", device);
  EXPECT_TRUE(writePng(device, Raster<Rgba8>(2, 2)));
  EXPECT_FALSE(writeTiffFloat(device, Raster<float>(2, 2)));
  EXPECT_TRUE(std::filesystem::is_symlink(device));
  EXPECT_TRUE(std::filesystem::is_character_file(device));
}

}  // namespace
}  // namespace tellurion::raster
