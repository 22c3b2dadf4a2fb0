#include "raster/service_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include "geo/seed_test.h"
#include "raster/grid_fixture_test.h"
#include "raster/image_check.h"

namespace tellurion::raster {
namespace {

using namespace testing;

io::Resource resourceOf(const std::filesystem::path& path, std::string type = {}) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  io::Resource resource{.bytes = {}, .contentType = std::move(type)};
  resource.bytes.resize(text.size());
  std::memcpy(resource.bytes.data(), text.data(), text.size());
  return resource;
}

io::Resource encoded(const Raster<Rgba8>& image, ImageFormat format = ImageFormat::png) {
  return {.bytes = encodeImage(image, format, 100).value(), .contentType = "image/png"};
}

/// Another format out of a GeoTIFF.
void copyAs(const char* driver, const std::string& from, const std::string& to) {
  GDALDataset* source = GDALDataset::Open(from.c_str());
  ASSERT_NE(source, nullptr);
  GDALDataset* copy =
      GetGDALDriverManager()->GetDriverByName(driver)->CreateCopy(to.c_str(), source, FALSE, nullptr, nullptr, nullptr);
  ASSERT_NE(copy, nullptr) << driver;
  GDALClose(copy);
  GDALClose(source);
}

TEST(ServiceImage, HeightsInColoursComeBackWithinAStep) {
  auto random = geo::seededGenerator();
  Raster<float> heights(40, 30);
  for (float& h : heights.samples)
    h = static_cast<float>(geo::uniform(random, -999.0, 8800.0));
  heights.samples[7] = kNoData;
  const auto check = [&](HeightEncoding::Kind kind, double step_m, const std::function<std::uint32_t(double)>& code) {
    Raster<Rgba8> image(40, 30);
    for (std::size_t i = 0; i < image.samples.size(); ++i) {
      if (isNoData(heights.samples[i])) continue;
      const std::uint32_t c = code(static_cast<double>(heights.samples[i]));
      image.samples[i] = {static_cast<std::uint8_t>(c >> 16u), static_cast<std::uint8_t>(c >> 8u),
                          static_cast<std::uint8_t>(c), 255};
    }
    HeightEncoding encoding{.kind = kind};
    for (const ImageFormat format : {ImageFormat::png, ImageFormat::webp}) {
      const auto back = decodeServiceHeights(encoded(image, format), 40, 30, encoding, geo::earth());
      ASSERT_TRUE(back) << io::describe(back.error());
      for (std::size_t i = 0; i < heights.samples.size(); ++i) {
        if (isNoData(heights.samples[i])) {
          EXPECT_TRUE(isNoData(back->samples[i]));
        } else {
          EXPECT_NEAR(back->samples[i], heights.samples[i], 0.5 * step_m + 1e-3);
        }
      }
    }
    encoding.nodata = code(static_cast<double>(heights.samples[3]));
    EXPECT_TRUE(isNoData(decodeServiceHeights(encoded(image), 40, 30, encoding, geo::earth())->samples[3]));
    EXPECT_FALSE(decodeServiceHeights(encoded(image, ImageFormat::jpeg), 40, 30, encoding, geo::earth()));
  };
  const auto rounded = [](double v) { return static_cast<std::uint32_t>(std::lround(v)); };
  check(HeightEncoding::Kind::terrarium, 1.0 / 256, [&](double h) { return rounded((h + 32768.0) * 256.0); });
  check(HeightEncoding::Kind::mapboxRgb, 0.1, [&](double h) { return rounded((h + 10000.0) * 10.0); });
  check(HeightEncoding::Kind::centimetreRgb, 0.01, [&](double h) { return rounded((h + 1000.0) * 100.0) * 16; });
}

TEST(ServiceImage, HeightsOfOneBand) {
  const ScratchFolder folder;
  MadeRaster made{.width = 30, .height = 20, .type = GDT_UInt16, .reference = {}};
  made.value = [](int, int col, int row) { return col == 3 ? 65535.0 : 100.0 * col + row; };
  makeRaster(folder.file("a.tif"), made);
  copyAs("PNG", folder.file("a.tif"), folder.file("a.png"));
  const HeightEncoding encoding{.scale = 0.5, .offset_m = -200.0, .nodata = 65535.0};
  for (const char* name : {"a.tif", "a.png"}) {
    const auto heights = decodeServiceHeights(resourceOf(folder.file(name)), 30, 20, encoding, geo::earth());
    ASSERT_TRUE(heights) << io::describe(heights.error());
    EXPECT_EQ(heights->at(10, 5), 0.5f * 1005 - 200);
    EXPECT_TRUE(isNoData(heights->at(3, 5)));
    EXPECT_FALSE(decodeServiceHeights(resourceOf(folder.file(name)), 20, 30, encoding, geo::earth()));
  }
  // A void without its tag.
  EXPECT_TRUE(isNoData(decodeServiceHeights(resourceOf(folder.file("a.tif")), 30, 20, {}, geo::earth())->at(3, 0)));
}

TEST(ServiceImage, RawHeightsInBothByteOrders) {
  for (const bool bigEndian : {false, true}) {
    io::Resource shorts{.bytes = {}, .contentType = "application/bil16"};
    io::Resource floats{.bytes = {}, .contentType = "image/bil"};
    const auto put = [&](io::Resource& to, auto value) {
      std::array<std::byte, sizeof value> bytes;
      std::memcpy(bytes.data(), &value, sizeof value);
      if (bigEndian) std::ranges::reverse(bytes);
      to.bytes.insert(to.bytes.end(), bytes.begin(), bytes.end());
    };
    for (int i = 0; i < 12; ++i) {
      put(shorts, static_cast<std::int16_t>(i == 5 ? -9999 : i * 100 - 300));
      put(floats, i == 5 ? -9999.0f : static_cast<float>(i) * 100.25f - 300.0f);
    }
    const HeightEncoding encoding{.nodata = -9999.0, .bigEndian = bigEndian};
    const auto fromShorts = decodeServiceHeights(shorts, 4, 3, encoding, geo::earth()).value();
    const auto fromFloats = decodeServiceHeights(floats, 4, 3, encoding, geo::earth()).value();
    EXPECT_EQ(fromShorts.at(3, 2), 800.0f);
    EXPECT_EQ(fromShorts.at(0, 0), -300.0f);
    EXPECT_EQ(fromFloats.at(3, 2), 11 * 100.25f - 300.0f);
    EXPECT_TRUE(isNoData(fromShorts.at(1, 1)) && isNoData(fromFloats.at(1, 1)));
    EXPECT_TRUE(checkImage(shorts, {Kind::elevation, 4, 3, 2, false}));
    EXPECT_FALSE(checkImage(shorts, {Kind::elevation, 4, 4, 2, false}));
    EXPECT_FALSE(checkImage(shorts, {Kind::imagery, 4, 3, 0, false}));
  }
}

TEST(ServiceImage, PalettesGreyAndTransparency) {
  const ScratchFolder folder;
  MadeRaster made{.width = 16, .height = 8, .type = GDT_Byte, .reference = {}};
  made.value = [](int, int col, int) { return static_cast<double>(col % 4); };
  makeRaster(folder.file("grey.tif"), made);
  made.tune = [](GDALDataset& d) {
    GDALColorTable table;
    for (short i = 0; i < 4; ++i) {
      const GDALColorEntry entry{static_cast<short>(50 * i), static_cast<short>(200 - i), 7,
                                 static_cast<short>(i == 2 ? 0 : 255)};
      table.SetColorEntry(i, &entry);
    }
    d.GetRasterBand(1)->SetColorTable(&table);
    d.GetRasterBand(1)->SetNoDataValue(2.0);
  };
  makeRaster(folder.file("palette.tif"), made);
  for (const char* driver : {"PNG", "GIF"}) {
    copyAs(driver, folder.file("grey.tif"), folder.file("grey"));
    copyAs(driver, folder.file("palette.tif"), folder.file("palette"));
    const auto grey = decodeServiceImage(resourceOf(folder.file("grey")), 16, 8, std::nullopt);
    ASSERT_TRUE(grey) << driver << io::describe(grey.error());
    EXPECT_EQ(grey->at(3, 3), (Rgba8{3, 3, 3, 255})) << driver;
    const auto palette = decodeServiceImage(resourceOf(folder.file("palette")), 16, 8, Rgba8{150, 197, 7, 255});
    ASSERT_TRUE(palette) << driver << io::describe(palette.error());
    EXPECT_EQ(palette->at(1, 3), (Rgba8{50, 199, 7, 255})) << driver;
    EXPECT_EQ(palette->at(2, 3).a, 0) << driver;
    EXPECT_EQ(palette->at(3, 3).a, 0) << driver << ": the colour that was named as transparent";
    EXPECT_TRUE(checkImage(resourceOf(folder.file("grey")), {Kind::imagery, 16, 8, 0, false}));
    EXPECT_FALSE(checkImage(resourceOf(folder.file("grey")), {Kind::imagery, 8, 16, 0, false}));
  }
}

TEST(ServiceImage, WhatIsNoWholeImageIsToldFromItsEnds) {
  Raster<Rgba8> image(64, 64, Rgba8{10, 200, 30, 255});
  auto random = geo::seededGenerator();
  for (Rgba8& p : image.samples)
    p.r = static_cast<std::uint8_t>(random());
  for (const ImageFormat format : {ImageFormat::png, ImageFormat::jpeg, ImageFormat::webp}) {
    io::Resource whole = encoded(image, format);
    EXPECT_TRUE(checkImage(whole, {Kind::imagery, 64, 64, 0, false})) << nameOf(format);
    EXPECT_FALSE(checkImage(whole, {Kind::imagery, 64, 65, 0, false}));
    for (const double part : {0.0, 0.01, 0.3, 0.9}) {
      io::Resource cut = whole;
      cut.bytes.resize(static_cast<std::size_t>(part * static_cast<double>(whole.bytes.size())));
      EXPECT_FALSE(checkImage(cut, {Kind::imagery, 64, 64, 0, false})) << nameOf(format) << " " << part;
    }
  }
}

TEST(ServiceImage, HostileImagesAreFailuresOrSound) {
  GDALAllRegister();
  int files = 0;
  for (const auto& folder : hostileFolders()) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file() || entry.file_size() > (8u << 20u)) continue;
      const io::Resource resource = resourceOf(entry.path());
      ++files;
      std::vector<std::pair<int, int>> sizes{{256, 256}};
      if (const auto header = readImageHeader(resource.bytes)) sizes.emplace_back(header->width, header->height);
      CPLPushErrorHandler(CPLQuietErrorHandler);
      if (auto* dataset = GDALDataset::Open(entry.path().c_str())) {
        sizes.emplace_back(dataset->GetRasterXSize(), dataset->GetRasterYSize());
        GDALClose(dataset);
      }
      CPLPopErrorHandler();
      for (const auto& [width, height] : sizes) {
        if (width < 1 || height < 1 || width > 1500 || height > 1500) continue;
        const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
        if (const auto image = decodeServiceImage(resource, width, height, std::nullopt)) {
          EXPECT_EQ(image->samples.size(), pixels) << entry.path();
        }
        for (const auto kind : {HeightEncoding::Kind::band, HeightEncoding::Kind::terrarium}) {
          const auto heights = decodeServiceHeights(resource, width, height, {.kind = kind}, geo::earth());
          if (!heights) continue;
          EXPECT_EQ(heights->samples.size(), pixels) << entry.path();
          for (const float h : heights->samples)
            EXPECT_TRUE(isNoData(h) || (h >= -12000.0f && h <= 9000.0f)) << entry.path();
        }
        const auto looked = checkImage(resource, {Kind::imagery, width, height, 0, false});
        EXPECT_TRUE(looked || !looked.error().message.empty());
      }
    }
  }
  EXPECT_GT(files, 3);
}

}  // namespace
}  // namespace tellurion::raster
