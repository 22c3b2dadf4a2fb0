#include "raster/picture_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "geo/seed_test.h"
#include "raster/codec.h"
#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

using namespace testing;

using Bytes = std::vector<std::byte>;

Bytes bytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

Bytes picture(ImageFormat format) {
  Raster<Rgba8> image(40, 30, Rgba8{0, 60, 70, 255});
  auto random = geo::seededGenerator();
  for (Rgba8& p : image.samples)
    p.r = static_cast<std::uint8_t>(random());
  return encodeImage(image, format, 90).value();
}

TEST(PictureFile, NoByteOfAPngMayBeAnother) {
  const Bytes whole = picture(ImageFormat::png);
  ASSERT_EQ(sizeOfWholePicture(whole).value(), (ImageSize{40, 30}));
  auto random = geo::seededGenerator();
  for (std::size_t i = 0; i < whole.size(); ++i) {
    Bytes spoilt = whole;
    spoilt[i] ^= static_cast<std::byte>(1U << (random() % 8));
    EXPECT_FALSE(sizeOfWholePicture(spoilt)) << "byte " << i;
  }
}

TEST(PictureFile, WhatIsCutShortIsNotWhole) {
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpeg, ImageFormat::webp}) {
    Bytes bytes = picture(format);
    EXPECT_EQ(sizeOfWholePicture(bytes).value(), (ImageSize{40, 30})) << nameOf(format);
    while (!bytes.empty()) {
      bytes.pop_back();
      EXPECT_FALSE(sizeOfWholePicture(bytes)) << nameOf(format) << " cut to " << bytes.size();
    }
  }
}

/// As GDAL writes them: strips, tiles, both byte orders, BigTIFF, compressed, directories before and after the pixels.
TEST(PictureFile, TiffsAreWholeUncutAndNotOtherwise) {
  const ScratchFolder folder;
  const std::vector<std::vector<const char*>> kinds{
      {},
      {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=32"},
      {"ENDIANNESS=BIG", "BLOCKYSIZE=1"},
      {"BIGTIFF=YES"},
      {"BIGTIFF=YES", "ENDIANNESS=BIG", "TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"},
      {"COMPRESS=DEFLATE"},
      {"COMPRESS=LZW", "TILED=YES", "BLOCKXSIZE=32", "BLOCKYSIZE=32"}};
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const std::string path = folder.file("a.tif");
    MadeRaster made{.width = 47, .height = 35, .type = GDT_Float32, .options = kinds[kind]};
    made.value = [](int, int col, int row) { return 100.0 * col * row; };
    makeRaster(path, made);
    const Bytes whole = bytesOf(path);
    ASSERT_EQ(pictureFormatOf(whole), PictureFormat::tiff);
    const auto size = sizeOfWholePicture(whole);
    ASSERT_TRUE(size) << kind << ": " << io::describe(size.error());
    EXPECT_EQ(*size, (ImageSize{47, 35})) << kind;
    // The last byte may fill up to an even number.
    for (std::size_t length = 4; length + 2 < whole.size(); ++length)
      EXPECT_FALSE(sizeOfWholePicture(std::span(whole).first(length))) << kind << " cut to " << length;
  }
}

TEST(PictureFile, SpoiltTiffsAreFailuresOrSizes) {
  const ScratchFolder folder;
  const std::string path = folder.file("a.tif");
  MadeRaster made{
      .width = 47, .height = 35, .type = GDT_Byte, .options = {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16"}};
  made.value = [](int, int col, int row) { return static_cast<double>((col * row) % 200); };
  makeRaster(path, made);
  const Bytes whole = bytesOf(path);
  auto random = geo::seededGenerator();
  int failures = 0;
  for (int i = 0; i < 20000; ++i) {
    Bytes spoilt = whole;
    for (int n = 0; n < 4; ++n)
      spoilt[4 + random() % 500] = static_cast<std::byte>(random());
    failures += sizeOfWholePicture(spoilt) ? 0 : 1;
  }
  EXPECT_GT(failures, 1000);
}

}  // namespace
}  // namespace tellurion::raster
