#include "raster/reduce.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raster/colour.h"

namespace tellurion::raster {
namespace {

constexpr Rgba8 kNone{};

TEST(Colour, EveryByteComesBackFromLinearLight) {
  for (int i = 0; i < 256; ++i) {
    const auto byte = static_cast<std::uint8_t>(i);
    EXPECT_EQ(srgbFromLinear(linearFromSrgb(byte)), byte);
  }
  EXPECT_EQ(linearFromSrgb(0), 0);
  EXPECT_EQ(linearFromSrgb(255), 65535);
  // IEC 61966-2-1: sRGB 0.5 is 0.21404 of full light.
  EXPECT_NEAR(linearFromSrgb(188) / 65535.0, 0.5028, 1e-4);
}

TEST(Colour, OverKeepsItsEndsAndBlendsLight) {
  const Rgba8 red{255, 0, 0, 255};
  const Rgba8 blue{0, 0, 255, 255};
  EXPECT_EQ(over(red, blue), red);
  EXPECT_EQ(over(kNone, blue), blue);
  EXPECT_EQ(over(kNone, kNone), kNone);
  EXPECT_EQ(over({9, 8, 7, 6}, kNone), (Rgba8{9, 8, 7, 6}));
  const Rgba8 half = over({255, 255, 255, 128}, {0, 0, 0, 255});
  EXPECT_NEAR(half.r, 188, 1);
  EXPECT_EQ(half.a, 255);
  EXPECT_EQ(over({10, 20, 30, 128}, {10, 20, 30, 128}).g, 20);
  EXPECT_EQ(over({10, 20, 30, 128}, {10, 20, 30, 128}).a, 192);
}

TEST(Reduce, MeansAreOfLight) {
  Raster<Rgba8> chequered(4, 2);
  for (int row = 0; row < 2; ++row) {
    for (int col = 0; col < 4; ++col) {
      const std::uint8_t v = (col + row) % 2 == 0 ? 255 : 0;
      chequered.at(col, row) = {v, v, v, 255};
    }
  }
  const auto half = halved(chequered);
  ASSERT_EQ(half.width, 2);
  ASSERT_EQ(half.height, 1);
  EXPECT_EQ(half.at(0, 0), (Rgba8{188, 188, 188, 255}));
}

TEST(Reduce, WhatHasNoCoverageLendsNoColour) {
  Raster<Rgba8> image(2, 2, Rgba8{255, 255, 255, 0});
  EXPECT_EQ(halved(image).at(0, 0), kNone);
  image.at(1, 1) = {10, 20, 30, 255};
  EXPECT_EQ(halved(image).at(0, 0), (Rgba8{10, 20, 30, 64}));
  image.at(1, 1).a = 1;
  EXPECT_EQ(halved(image).at(0, 0), (Rgba8{10, 20, 30, 1}));
}

TEST(Reduce, OddAndSmallSizes) {
  EXPECT_EQ(halved(Raster<Rgba8>(5, 3)).width, 2);
  EXPECT_EQ(halved(Raster<Rgba8>(5, 3)).height, 1);
  const Rgba8 p{1, 2, 3, 200};
  EXPECT_EQ(halved(Raster<Rgba8>(1, 1, p)).at(0, 0), p);
  EXPECT_EQ(halved(Raster<Rgba8>(1, 4, p)).at(0, 1), p);
  EXPECT_TRUE(halved(Raster<Rgba8>()).samples.empty());
}

TEST(Reduce, OneColourStaysItself) {
  for (int i = 0; i < 256; ++i) {
    const auto v = static_cast<std::uint8_t>(i);
    EXPECT_EQ(halved(Raster<Rgba8>(2, 2, Rgba8{v, v, v, 255})).at(0, 0), (Rgba8{v, v, v, 255}));
  }
}

}  // namespace
}  // namespace tellurion::raster
