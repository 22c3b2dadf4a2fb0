#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "geo/seed_test.h"
#include "raster/codec.h"

namespace tellurion::raster {
namespace {

bool sameBits(const Raster<float>& a, const Raster<float>& b) {
  return a.width == b.width && a.height == b.height &&
         std::memcmp(a.samples.data(), b.samples.data(), a.samples.size() * sizeof(float)) == 0;
}

void expectRoundTrip(const Raster<float>& heights, double step_m) {
  const auto bytes = encodeElevation(heights, step_m);
  const auto back = decodeElevation(bytes, heights.width, heights.height);
  ASSERT_TRUE(back) << io::describe(back.error());
  EXPECT_TRUE(sameBits(heights, *back)) << "step " << step_m << ", " << heights.width << " x " << heights.height;
}

/// Terrain-like: smooth and a little rough, with holes.
Raster<float> terrain(int width, int height, double step_m, double holes, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Raster<float> r(width, height);
  const double phase = 10.0 * uniform(random);
  for (int row = 0; row < height; ++row) {
    for (int col = 0; col < width; ++col) {
      const double h = 900.0 * std::sin(phase + 0.1 * col) * std::cos(0.07 * row) + 20.0 * uniform(random);
      const double multiple = std::round(h / step_m) * step_m;
      r.at(col, row) = uniform(random) < holes ? kNoData : static_cast<float>(multiple) + 0.0f;
    }
  }
  return r;
}

TEST(ElevationCodec, MultiplesOfEveryPowerOfTwoStepComeBackBitForBit) {
  const unsigned seed = geo::testSeed();
  RecordProperty("seed", static_cast<int>(seed));
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int exponent = -14; exponent <= 6; ++exponent) {
    for (const double holes : {0.0, 0.1, 0.9, 1.0}) {
      const double step_m = std::exp2(exponent);
      expectRoundTrip(terrain(67, 67, step_m, holes, random), step_m);
    }
  }
}

TEST(ElevationCodec, FloatsComeBackBitForBitAndEveryNanAsNoData) {
  std::mt19937 random(7);
  Raster<float> r(67, 67);
  for (float& v : r.samples) {
    v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (std::isnan(v)) v = kNoData;
  }
  expectRoundTrip(r, 0.0);
  r.at(3, 4) = std::bit_cast<float>(0xffc12345u);
  const auto back = decodeElevation(encodeElevation(r, 0.0), r.width, r.height);
  ASSERT_TRUE(back);
  EXPECT_EQ(std::bit_cast<std::uint32_t>(back->at(3, 4)), std::bit_cast<std::uint32_t>(kNoData));
}

TEST(ElevationCodec, ExtremesAndOddShapes) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kMax = std::numeric_limits<float>::max();
  constexpr float kLimit = 268435456.0f;  // 2^28
  Raster<float> r(5, 1);
  r.samples = {kMax, -kMax, kInf, -kInf, -0.0f};
  expectRoundTrip(r, 0.0);
  expectRoundTrip(r, 1.0);  // does not fit multiples: falls back to floats
  Raster<float> jumps(3, 3);
  jumps.samples = {kLimit, -kLimit, kLimit, -kLimit, kLimit, -kLimit, kLimit, kNoData, -kLimit};
  expectRoundTrip(jumps, 1.0);
  expectRoundTrip(Raster<float>(1, 1, kNoData), 0.5);
  expectRoundTrip(Raster<float>(1, 300, 12.0f), 0.5);
  expectRoundTrip(Raster<float>(300, 1, 12.0f), 0.5);
  for (const double step_m : {-1.0, 1e10, std::nan(""), std::numeric_limits<double>::infinity()}) {
    expectRoundTrip(Raster<float>(4, 4, 1.25f), step_m);
  }
}

TEST(ElevationCodec, SmoothTerrainBecomesSmall) {
  std::mt19937 random(1);
  const auto bytes = encodeElevation(terrain(67, 67, 1.0, 0.0, random), 1.0);
  EXPECT_LT(bytes.size(), 67u * 67u * 3u / 2u);
  EXPECT_LT(encodeElevation(Raster<float>(67, 67, kNoData), 1.0).size(), 64u);
}

TEST(ElevationCodec, OnlyTheStatedSizeIsAccepted) {
  const auto bytes = encodeElevation(Raster<float>(67, 67, 5.0f), 1.0);
  EXPECT_FALSE(decodeElevation(bytes, 66, 67));
  EXPECT_FALSE(decodeElevation(bytes, 68, 67));
  EXPECT_FALSE(decodeElevation(bytes, 0, 67));
  EXPECT_FALSE(decodeElevation(bytes, 67, -1));
  EXPECT_FALSE(decodeElevation(bytes, kMaxCodecSide + 1, 1));
  EXPECT_FALSE(decodeElevation({}, 67, 67));
}

TEST(ElevationCodec, DamagedStepsAreRefused) {
  auto bytes = encodeElevation(Raster<float>(8, 8, 5.0f), 1.0);
  for (const double step_m : {0.0, -1.0, 2e9, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto bits = std::bit_cast<std::array<std::byte, 8>>(step_m);
    std::ranges::copy(bits, bytes.begin() + 1);
    EXPECT_FALSE(decodeElevation(bytes, 8, 8)) << step_m;
  }
}

/// Whatever is done to the bytes, the answer is a failure or a raster; the sanitizers watch.
TEST(ElevationCodec, TruncationsAndBitFlipsNeverCrash) {
  const unsigned seed = geo::testSeed();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const double step_m : {0.0, 0.0625}) {
    const auto good = encodeElevation(terrain(19, 17, 0.0625, 0.1, random), step_m);
    for (std::size_t size = 0; size < good.size(); ++size) {
      EXPECT_FALSE(decodeElevation(std::span(good).first(size), 19, 17)) << size;
    }
    for (int i = 0; i < 3000; ++i) {
      auto bad = good;
      const auto flips = 1 + random() % 3;
      for (unsigned k = 0; k < flips; ++k)
        bad[random() % bad.size()] ^= static_cast<std::byte>(1u << (random() % 8));
      const auto decoded = decodeElevation(bad, 19, 17);
      if (decoded) {
        EXPECT_EQ(decoded->samples.size(), 19u * 17u);
      }
    }
  }
}

}  // namespace
}  // namespace tellurion::raster
