#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "geo/seed_test.h"
#include "raster/codec.h"
#include "raster/raster_fixture_test.h"

namespace tellurion::raster {
namespace {

namespace fs = std::filesystem;

Raster<Rgba8> picture(int width, int height, bool opaque) {
  Raster<Rgba8> r(width, height);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      const auto wave = [&](double f) {
        return static_cast<std::uint8_t>(127.5 + 127.0 * std::sin(f * col + 0.05 * row));
      };
      const std::uint8_t a = opaque ? std::uint8_t{255} : static_cast<std::uint8_t>((col * 7 + row) % 256);
      r.at(col, row) = {wave(0.02), wave(0.03), wave(0.05), a};
    }
  }
  return r;
}

/// The largest difference of a colour where there is coverage, and of coverage anywhere.
int difference(const Raster<Rgba8>& a, const Raster<Rgba8>& b) {
  int worst = 0;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const Rgba8 p = a.samples[i];
    const Rgba8 q = b.samples[i];
    worst = std::max(worst, std::abs(p.a - q.a));
    if (p.a == 0) continue;
    worst = std::max({worst, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
  }
  return worst;
}

Raster<Rgba8> roundTrip(const Raster<Rgba8>& image, ImageFormat format, int quality) {
  const auto bytes = encodeImage(image, format, quality);
  EXPECT_TRUE(bytes) << io::describe(bytes.error());
  const auto header = readImageHeader(*bytes);
  EXPECT_TRUE(header && header->format == format && header->width == image.width && header->height == image.height);
  auto back = decodeImage(*bytes, image.width, image.height);
  EXPECT_TRUE(back) << io::describe(back.error());
  return back.value_or(Raster<Rgba8>(image.width, image.height));
}

std::vector<std::byte> contents(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::vector<std::byte> bytes(text.size());
  std::ranges::transform(text, bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

TEST(ImageCodec, PngAndLosslessWebpComeBackExactly) {
  for (const bool opaque : {true, false}) {
    for (const auto& [w, h] : {std::pair{258, 258}, {1, 1}, {3, 200}, {200, 3}}) {
      const auto image = picture(w, h, opaque);
      EXPECT_EQ(difference(image, roundTrip(image, ImageFormat::png, 1)), 0);
      EXPECT_EQ(difference(image, roundTrip(image, ImageFormat::webp, 100)), 0);
    }
  }
}

TEST(ImageCodec, JpegAndWebpStayClose) {
  const auto image = picture(258, 258, true);
  EXPECT_LE(difference(image, roundTrip(image, ImageFormat::jpeg, 95)), 12);
  EXPECT_LE(difference(image, roundTrip(image, ImageFormat::webp, 95)), 24);
  EXPECT_LT(encodeImage(image, ImageFormat::jpeg, 80)->size(), encodeImage(image, ImageFormat::jpeg, 98)->size());
}

TEST(ImageCodec, JpegDropsCoverageAndWebpKeepsItExactly) {
  const auto image = picture(64, 64, false);
  for (const Rgba8& p : roundTrip(image, ImageFormat::jpeg, 90).samples)
    EXPECT_EQ(p.a, 255);
  const auto webp = roundTrip(image, ImageFormat::webp, 80);
  for (std::size_t i = 0; i < webp.samples.size(); ++i)
    EXPECT_EQ(webp.samples[i].a, image.samples[i].a);
}

TEST(ImageCodec, NoiseFitsTheJpegBuffer) {
  std::mt19937 random(3);
  Raster<Rgba8> noise(61, 47);
  for (Rgba8& p : noise.samples) {
    p = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
         255};
  }
  EXPECT_LE(difference(noise, roundTrip(noise, ImageFormat::jpeg, 100)), 255);
}

TEST(ImageCodec, SizesAreChecked) {
  EXPECT_FALSE(encodeImage({}, ImageFormat::png, 90));
  EXPECT_FALSE(encodeImage(Raster<Rgba8>(kMaxCodecSide + 1, 1), ImageFormat::jpeg, 90));
  for (const ImageFormat format : {ImageFormat::jpeg, ImageFormat::png, ImageFormat::webp}) {
    const auto bytes = encodeImage(picture(64, 32, true), format, 90);
    ASSERT_TRUE(bytes);
    EXPECT_FALSE(decodeImage(*bytes, 32, 64)) << nameOf(format);
    EXPECT_FALSE(decodeImage(*bytes, 65, 32)) << nameOf(format);
    EXPECT_FALSE(decodeImage(*bytes, 0, 0)) << nameOf(format);
    EXPECT_FALSE(decodeImage(*bytes, 1 << 20, 1 << 20)) << nameOf(format);
  }
  EXPECT_FALSE(decodeImage({}, 4, 4));
}

TEST(ImageCodec, TruncationsAndBitFlipsNeverCrash) {
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const ImageFormat format : {ImageFormat::jpeg, ImageFormat::png, ImageFormat::webp}) {
    for (const bool opaque : {true, false}) {
      const auto encoded = encodeImage(picture(40, 30, opaque), format, 85);
      ASSERT_TRUE(encoded);
      for (std::size_t size = 0; size < encoded->size(); size += 1 + encoded->size() / 200) {
        // A picture that lacks no more than its end mark may still be whole.
        const bool decoded = decodeImage(std::span(*encoded).first(size), 40, 30).has_value();
        EXPECT_TRUE(!decoded || size + 24 > encoded->size()) << nameOf(format) << " cut at " << size;
      }
      for (int i = 0; i < 1500; ++i) {
        auto bad = *encoded;
        const auto flips = 1 + random() % 4;
        for (unsigned k = 0; k < flips; ++k)
          bad[random() % bad.size()] ^= static_cast<std::byte>(1u << (random() % 8));
        const auto decoded = decodeImage(bad, 40, 30);
        if (decoded) {
          EXPECT_EQ(decoded->samples.size(), 1200u);
        }
      }
    }
  }
}

TEST(ImageCodec, HostilePicturesFailCleanlyOrDecode) {
  std::vector<fs::path> folders;
  for (const fs::path& hostile : testing::hostileFolders()) {
    folders.push_back(hostile / "jpeg");
    folders.push_back(hostile / "png");
  }
  int seen = 0;
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      const auto bytes = contents(entry.path());
      ++seen;
      const auto header = readImageHeader(bytes);
      if (!header) {
        EXPECT_FALSE(header.error().message.empty()) << entry.path();
        continue;
      }
      const auto image = decodeImage(bytes, header->width, header->height);
      if (!image) {
        EXPECT_FALSE(image.error().message.empty()) << entry.path();
      }
    }
  }
  EXPECT_GT(seen, 10);
}

TEST(ImageCodec, PicturesThatMustBeRejectedAre) {
  int seen = 0;
  for (const fs::path& hostile : testing::hostileFolders()) {
    for (const char* name :
         {"jpeg/mars_truncated.jpg", "jpeg/pillow_truncated_jpeg.jpg", "png/xs2n0g01.png", "png/xhdn0g08.png",
          "png/xcsn0g01.png", "png/pillow_truncated_image.png", "png/x_ihdr_missing.png"}) {
      if (!fs::exists(hostile / name)) continue;  // the project carries the small ones
      ++seen;
      const auto bytes = contents(hostile / name);
      const auto header = readImageHeader(bytes);
      EXPECT_FALSE(header && decodeImage(bytes, header->width, header->height)) << name;
    }
  }
  EXPECT_GE(seen, 4);
}

}  // namespace
}  // namespace tellurion::raster
