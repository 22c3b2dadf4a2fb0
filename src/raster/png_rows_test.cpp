#include "raster/png_rows.h"

#include <gtest/gtest.h>

#include <random>

#include "geo/seed_test.h"
#include "raster/image_file.h"

namespace tellurion::raster {
namespace {

std::filesystem::path placeFor(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / name;
}

TEST(PngRows, bandsMakeTheWholePicture) {
  std::mt19937_64 random = geo::seededGenerator();
  Raster<Rgba8> whole(123, 57);
  for (Rgba8& p : whole.samples)
    p = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
         255};
  const auto path = placeFor("png_rows_bands.png");
  auto file = PngRows::create(path, whole.width, whole.height);
  ASSERT_TRUE(file) << io::describe(file.error());
  for (int top = 0; top < whole.height; top += 13) {
    Raster<Rgba8> band(whole.width, std::min(13, whole.height - top));
    std::copy_n(whole.samples.begin() + std::ptrdiff_t{top} * whole.width, band.samples.size(), band.samples.begin());
    EXPECT_FALSE(std::filesystem::exists(path)) << "before it is whole";
    ASSERT_TRUE(file->write(band));
  }
  ASSERT_TRUE(file->finish());
  const auto read = readImageFile(path);
  ASSERT_TRUE(read) << io::describe(read.error());
  EXPECT_EQ(read->samples, whole.samples);
  std::filesystem::remove(path);
}

TEST(PngRows, whatIsNotFinishedLeavesNothing) {
  const auto path = placeFor("png_rows_half.png");
  {
    auto file = PngRows::create(path, 10, 10);
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->write(Raster<Rgba8>(10, 5)));
    EXPECT_FALSE(file->write(Raster<Rgba8>(9, 5))) << "of another width";
    EXPECT_FALSE(file->write(Raster<Rgba8>(10, 6))) << "too many";
    EXPECT_FALSE(file->finish()) << "too few";
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".part"));
}

TEST(PngRows, saysWhereItCannotWrite) {
  const auto nowhere = PngRows::create("/nowhere/at/all.png", 10, 10);
  ASSERT_FALSE(nowhere);
  EXPECT_EQ(nowhere.error().where, "/nowhere/at/all.png");
  EXPECT_FALSE(PngRows::create(placeFor("png_rows_large.png"), 2'000'000, 1));
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  auto full = PngRows::create("/dev/full", 400, 400);
  ASSERT_TRUE(full);
  std::mt19937_64 random(1);
  Raster<Rgba8> noise(400, 400);
  for (Rgba8& p : noise.samples)
    p.r = static_cast<std::uint8_t>(random());
  const bool isWritten = full->write(noise).has_value() && full->finish().has_value();
  EXPECT_FALSE(isWritten);
}

}  // namespace
}  // namespace tellurion::raster
