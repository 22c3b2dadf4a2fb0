#include "raster/block_compression.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <string>

#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

constexpr int kTile = 258;

struct Difference {
  double psnr_dB = 0.0;
  double mean = 0.0;  ///< of 255, over the channels
};

Difference differenceOf(const Raster<Rgba8>& a, const Raster<Rgba8>& b) {
  double squares = 0.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const Rgba8 p = a.samples[i];
    const Rgba8 q = b.samples[i];
    for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) {
      squares += d * d;
      sum += std::abs(d);
    }
  }
  const double count = 3.0 * static_cast<double>(a.samples.size());
  return {.psnr_dB = 10.0 * std::log10(255.0 * 255.0 * count / std::max(squares, 1.0)), .mean = sum / count};
}

/// The middle of the first three bands of a file.
Raster<Rgba8> middleOf(const std::string& path, int side) {
  GDALAllRegister();
  const GDALDatasetUniquePtr file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!file) {
    ADD_FAILURE() << path;
    return {1, 1};
  }
  Raster<Rgba8> out(side, side, {0, 0, 0, 255});
  const int left = (file->GetRasterXSize() - side) / 2;
  const int top = (file->GetRasterYSize() - side) / 2;
  EXPECT_EQ(file->RasterIO(GF_Read, left, top, side, side, out.samples.data(), side, side, GDT_Byte, 3, nullptr, 4,
                           GSpacing{4} * side, 1, nullptr),
            CE_None);
  return out;
}

Rgba8 randomColour(std::mt19937_64& random) {
  const auto byte = [&] { return static_cast<std::uint8_t>(random() % 256); };
  return {byte(), byte(), byte(), byte()};
}

TEST(BlockCompression, RealPicturesStayClose) {
  struct Case {
    const char* file;
    double leastPsnr_dB;
    double mostMean;
  };
  const std::string folder = TELLURION_SHARED_DATA_DIR "/earth/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no " << folder;
  for (const Case& c : {Case{"bluemarble_dec2004_5400x2700.jpg", 36.0, 2.5},
                        Case{"sentinel2_pair/T33UUS_20150803_rgb_100m.tif", 29.5, 6.5},
                        Case{"everest_landsat7_rgb_30m.tif", 32.0, 4.0}, Case{"santabarbara_rgb_3m.tif", 29.0, 6.5}}) {
    const Raster<Rgba8> tile = middleOf(folder + c.file, kTile);
    for (const BlockFormat format : {BlockFormat::bc1, BlockFormat::bc3}) {
      const std::clock_t start = std::clock();
      const BlockPicture blocks = compressed(tile, format);
      const double ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      const Difference d = differenceOf(tile, decompressed(blocks));
      std::printf("%s: %.1f dB, mean difference %.2f of 255, %.1f ms\n", c.file, d.psnr_dB, d.mean, ms);
      EXPECT_GE(d.psnr_dB, c.leastPsnr_dB) << c.file;
      EXPECT_LE(d.mean, c.mostMean) << c.file;
    }
  }
}

TEST(BlockCompression, APlainColourIsKeptWithinAStepOfItsBits) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 2000; ++i) {
    const Raster<Rgba8> plain(4, 4, randomColour(random));
    const Rgba8 in = plain.samples[0];
    for (const BlockFormat format : {BlockFormat::bc1, BlockFormat::bc3}) {
      for (const Rgba8& out : decompressed(compressed(plain, format)).samples) {
        EXPECT_LE(std::abs(in.r - out.r), 4);
        EXPECT_LE(std::abs(in.g - out.g), 2);
        EXPECT_LE(std::abs(in.b - out.b), 4);
        EXPECT_EQ(out.a, format == BlockFormat::bc1 ? 255 : in.a);
      }
    }
  }
}

TEST(BlockCompression, CoverageIsKeptWithinHalfOfAFourteenthOfItsRange) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 2000; ++i) {
    const int low = static_cast<int>(random() % 256);
    const int range = 1 + static_cast<int>(random() % static_cast<unsigned>(256 - low));
    Raster<Rgba8> picture(4, 4);
    for (Rgba8& p : picture.samples)
      p.a = static_cast<std::uint8_t>(low + static_cast<int>(random() % static_cast<unsigned>(range)));
    const Raster<Rgba8> out = decompressed(compressed(picture, BlockFormat::bc3));
    for (std::size_t k = 0; k < out.samples.size(); ++k) {
      EXPECT_NEAR(picture.samples[k].a, out.samples[k].a, range / 14.0 + 1.5);
      EXPECT_EQ(out.samples[k].r + out.samples[k].g + out.samples[k].b, 0);
    }
  }
}

// Any size: what lies beyond the picture must not show, so each block's colours stay among its own.
TEST(BlockCompression, PicturesOfAnySizeAreCutOutOfTheirBlocks) {
  auto random = geo::seededGenerator();
  for (int i = 0; i < 300; ++i) {
    const int width = 1 + static_cast<int>(random() % 23);
    const int height = 1 + static_cast<int>(random() % 23);
    Raster<Rgba8> picture(width, height);
    const Rgba8 a = randomColour(random);
    const Rgba8 b = randomColour(random);
    for (int row = 0; row < height; ++row) {
      for (int col = 0; col < width; ++col)
        picture.at(col, row) = (col / 4 + row / 4) % 2 == 0 ? a : b;
    }
    for (const BlockFormat format : {BlockFormat::bc1, BlockFormat::bc3}) {
      const BlockPicture blocks = compressed(picture, format);
      const int count = (width + 3) / 4 * ((height + 3) / 4);
      EXPECT_EQ(blocks.bytes.size(), static_cast<std::size_t>(count * (format == BlockFormat::bc1 ? 8 : 16)));
      EXPECT_EQ(blocks.bytes.size(), blockBytes(format, width, height));
      const Raster<Rgba8> out = decompressed(blocks);
      ASSERT_EQ(out.width, width);
      ASSERT_EQ(out.height, height);
      for (std::size_t k = 0; k < out.samples.size(); ++k) {
        EXPECT_NEAR(picture.samples[k].r, out.samples[k].r, 4);
        EXPECT_NEAR(picture.samples[k].g, out.samples[k].g, 2);
        EXPECT_NEAR(picture.samples[k].b, out.samples[k].b, 4);
      }
    }
  }
}

}  // namespace
}  // namespace tellurion::raster
