// Composed against the definition in double precision: layers from below, each over what is there, in linear light.
#include "scene/colour_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

using raster::Rgba8;
using tiling::TileId;
using Picture = raster::Raster<Rgba8>;

constexpr int kPixels = 8;
constexpr int kSide = kPixels + 2;
constexpr TileId kRoot{0, 2, 0, 0};
constexpr TileId kChild{1, 2, 1, 0};
constexpr TileId kGrandchild{2, 2, 3, 0};  // of kChild, right half, top

Picture plain(Rgba8 colour) {
  return Picture(kSide, kSide, colour);
}

Picture randomPicture(std::mt19937_64& random, bool isOpaque) {
  Picture picture(kSide, kSide);
  for (Rgba8& p : picture.samples) {
    const std::uint64_t bits = random();
    p = {static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8), static_cast<std::uint8_t>(bits >> 16),
         static_cast<std::uint8_t>(bits >> 24)};
    if (isOpaque) p.a = 255;
  }
  return picture;
}

/// Exactly the tiles that a test paints.
class PaintedSource final : public raster::TileSource {
 public:
  explicit PaintedSource(int maxLevel = 2) {
    info_ = {.name = "painted", .kind = raster::Kind::imagery, .tileCells = kPixels, .maxLevel = maxLevel};
  }
  std::map<TileId, Picture> tiles;
  std::set<TileId> failing;  ///< listed by their parents, but cannot be loaded
  std::set<TileId> missing;  ///< listed by their parents, but not there

  const raster::TileSourceInfo& info() const override { return info_; }
  io::Result<std::optional<raster::SourceTile>> load(const TileId& id) const override {
    if (failing.contains(id)) return io::fail(io::Failure::Code::ioError, "made to fail");
    const auto found = tiles.find(id);
    if (found == tiles.end()) return std::optional<raster::SourceTile>();
    raster::SourceTile tile;
    tile.payload = raster::ImageryTile{found->second};
    for (int q = 0; q < 4; ++q) {
      const TileId child = id.child(q);
      const bool isListed = tiles.contains(child) || failing.contains(child) || missing.contains(child);
      if (isListed) tile.childMask = static_cast<std::uint8_t>(tile.childMask | (1u << q));
    }
    return std::optional(std::move(tile));
  }

 private:
  raster::TileSourceInfo info_;
};

struct Painted {
  std::map<TileId, Picture> tiles;
  double opacity = 1.0;
  bool nightLights = false;
  std::set<TileId> failing = {};
  std::set<TileId> missing = {};
};

struct Stack {
  std::shared_ptr<LoadLedger> ledger = std::make_shared<LoadLedger>();
  std::vector<ColourLayers::Layer> layers;

  explicit Stack(const std::vector<Painted>& painted) {
    for (const Painted& p : painted) {
      auto source = std::make_shared<PaintedSource>();
      source->tiles = p.tiles;
      source->failing = p.failing;
      source->missing = p.missing;
      layers.push_back({.tiles = std::make_shared<LayerTiles>(source, 1u << 20u, ledger),
                        .opacity = p.opacity,
                        .nightLights = p.nightLights});
    }
  }
  ComposedColour compose(const TileId& id) const { return ColourLayers(layers, kPixels).compose(id); }
};

/// The finest picture; empty: none was made.
Picture composed(const std::vector<Painted>& painted, const TileId& id) {
  const ComposedColour colour = Stack(painted).compose(id);
  return colour.image ? colour.image->mips.front() : Picture();
}

void expectPlain(const Picture& picture, Rgba8 colour) {
  ASSERT_EQ(picture.samples.size(), static_cast<std::size_t>(kSide * kSide));
  for (const Rgba8& p : picture.samples)
    ASSERT_EQ(p, colour) << int{p.r} << " " << int{p.g} << " " << int{p.b} << " " << int{p.a};
}

// ---- The definition, in double precision

double light(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

double byteOf(double linear) {
  return 255.0 * (linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055);
}

struct Light {
  std::array<double, 3> rgb{};
  double coverage = 0.0;
};

Light lightOf(Rgba8 p) {
  return {{light(p.r), light(p.g), light(p.b)}, p.a / 255.0};
}

Rgba8 nightless(Rgba8 p) {
  return {p.r, p.g, p.b, 0};
}

/// Off by one byte at most: of the colour, or (at small coverage) of the coverage.
void expectNear(Rgba8 actual, const std::array<double, 3>& expected, double tolerance = 1.01) {
  EXPECT_NEAR(actual.r, byteOf(expected[0]), tolerance);
  EXPECT_NEAR(actual.g, byteOf(expected[1]), tolerance);
  EXPECT_NEAR(actual.b, byteOf(expected[2]), tolerance);
}

// ---- Which tiles

TEST(ColourLayers, OnlyTilesOfTheirOwnHavePictures) {
  const Painted shallow{.tiles = {{kRoot, plain({10, 20, 30, 255})}}};
  EXPECT_EQ(Stack({shallow}).compose(kChild).image, nullptr);
  expectPlain(composed({shallow}, kRoot), {10, 20, 30, 0});
  EXPECT_EQ(Stack({}).compose(kRoot).image, nullptr);
}

TEST(ColourLayers, ARootIsPlainGroundWhereNothingIs) {
  expectPlain(composed({Painted{}}, kRoot), nightless(kPlainGround));
  expectPlain(composed({Painted{.tiles = {{kRoot, plain({9, 9, 9, 0})}}}}, kRoot), nightless(kPlainGround));
}

TEST(ColourLayers, TheFinestTileOfALayerWins) {
  const Painted deep{.tiles = {{kRoot, plain({200, 0, 0, 255})},
                               {kChild, plain({0, 200, 0, 255})},
                               {kGrandchild, plain({0, 0, 200, 255})}}};
  expectPlain(composed({deep}, kRoot), {200, 0, 0, 0});
  expectPlain(composed({deep}, kChild), {0, 200, 0, 0});
  expectPlain(composed({deep}, kGrandchild), {0, 0, 200, 0});
}

TEST(ColourLayers, AnUpperLayerLiesOverAFinerOneBelowIt) {
  const Painted fine{.tiles = {{kRoot, plain({1, 1, 1, 255})}, {kChild, plain({0, 200, 0, 255})}}};
  const Painted coarse{.tiles = {{kRoot, plain({200, 0, 0, 255})}}};
  expectPlain(composed({fine, coarse}, kChild), {200, 0, 0, 0});
  expectPlain(composed({coarse, fine}, kChild), {0, 200, 0, 0});
}

TEST(ColourLayers, KnowsOfFinerTilesBelow) {
  const Painted deep{.tiles = {{kRoot, plain({1, 1, 1, 255})}, {kChild, plain({2, 2, 2, 255})}}};
  const Painted flat{.tiles = {{kRoot, plain({3, 3, 3, 255})}}};
  EXPECT_TRUE(Stack({flat, deep}).compose(kRoot).finerBelow);
  EXPECT_FALSE(Stack({flat}).compose(kRoot).finerBelow);
  EXPECT_FALSE(Stack({flat, deep}).compose(kChild).finerBelow);
}

// ---- Missing tiles

TEST(ColourLayers, ATileThatFailsIsItsParentEnlarged) {
  const Painted sound{.tiles = {{kRoot, plain({5, 5, 5, 255})}, {kChild, plain({6, 6, 6, 0})}}};
  for (const bool fails : {true, false}) {
    Painted hurt{.tiles = {{kRoot, plain({70, 80, 90, 255})}}};
    (fails ? hurt.failing : hurt.missing).insert(kChild);
    const Stack stack({sound, hurt});
    const ComposedColour colour = stack.compose(kChild);
    ASSERT_NE(colour.image, nullptr);
    expectPlain(colour.image->mips.front(), {70, 80, 90, 0});
    EXPECT_FALSE(colour.finerBelow);
  }
}

TEST(ColourLayers, AFailureIsOnTheLedgerOnceAndTheRestIsDrawn) {
  const Painted below{.tiles = {{kRoot, plain({5, 6, 7, 255})}}};
  const Stack stack({below, Painted{.failing = {kRoot}}});
  for (int i = 0; i < 3; ++i) {
    const ComposedColour colour = stack.compose(kRoot);
    ASSERT_NE(colour.image, nullptr);
    expectPlain(colour.image->mips.front(), {5, 6, 7, 0});
  }
  EXPECT_EQ(stack.ledger->takeFailures().size(), 1U);
}

// ---- Enlarging

/// Bilinear in linear light between the middles of an ancestor's pixels, weighted with coverage.
Light enlargedAt(const Picture& from, int levels, const TileId& id, int col, int row) {
  const double scale = std::exp2(-levels);
  const auto place = [&](std::uint32_t index, int i) {
    const double within = static_cast<double>(index % (1u << static_cast<unsigned>(levels)));
    return (within + (i - 0.5) / kPixels) * scale * kPixels + 0.5;  // in pixels of the ancestor, gutter included
  };
  const double x = place(id.x, col);
  const double y = place(id.y, row);
  const int left = static_cast<int>(std::floor(x));
  const int top = static_cast<int>(std::floor(y));
  Light sum;
  for (int i = 0; i < 4; ++i) {
    const Light p = lightOf(from.at(left + (i & 1), top + (i >> 1)));
    const double weight = std::abs(1 - (i & 1) - (x - left)) * std::abs(1 - (i >> 1) - (y - top)) * p.coverage;
    for (std::size_t c = 0; c < 3; ++c)
      sum.rgb[c] += weight * p.rgb[c];
    sum.coverage += weight;
  }
  for (double& c : sum.rgb)
    c = sum.coverage > 0.0 ? c / sum.coverage : 0.0;
  return sum;
}

TEST(ColourLayers, AnEnlargedAncestorIsBilinearInLinearLight) {
  auto random = geo::seededGenerator();
  const Painted own{.tiles = {{kRoot, plain({})}, {kChild, plain({})}, {kGrandchild, plain({})}}};
  for (int round = 0; round < 20; ++round) {
    const Picture ancestor = randomPicture(random, true);
    for (const TileId& id : {kChild, kGrandchild}) {
      const Picture picture = composed({own, {.tiles = {{kRoot, ancestor}}}}, id);
      ASSERT_EQ(picture.width, kSide);
      for (int row = 1; row <= kPixels; ++row) {
        for (int col = 1; col <= kPixels; ++col)
          expectNear(picture.at(col, row), enlargedAt(ancestor, id.level, id, col, row).rgb);
      }
    }
  }
}

TEST(ColourLayers, UncoveredPixelsOfAnAncestorDoNotBleed) {
  Picture half = plain({250, 0, 0, 255});
  for (int row = 0; row < kSide; ++row) {
    for (int col = 6; col < kSide; ++col)
      half.at(col, row) = {0, 250, 0, 0};
  }
  const Painted own{.tiles = {{kRoot, plain({})}, {kChild, plain({0, 0, 0, 255})}}};
  const Picture picture = composed({own, {.tiles = {{kRoot, half}}}}, kChild);
  for (const Rgba8& p : picture.samples)
    EXPECT_EQ(p.g, 0);
  EXPECT_EQ(picture.at(1, 4).r, 250);  // over the ancestor's columns 4.75..5
  EXPECT_EQ(picture.at(8, 4).r, 0);
}

// ---- Opacity and coverage

TEST(ColourLayers, OpacityAndCoverageMixInLinearLight) {
  auto random = geo::seededGenerator();
  for (int round = 0; round < 50; ++round) {
    const Picture bottom = randomPicture(random, true);
    const Picture top = randomPicture(random, round % 2 == 0);
    const double opacity = geo::uniform(random, 0.0, 1.0);
    const Picture picture =
        composed({{.tiles = {{kRoot, bottom}}}, {.tiles = {{kRoot, top}}, .opacity = opacity}}, kRoot);
    for (std::size_t i = 0; i < picture.samples.size(); ++i) {
      const Light under = lightOf(bottom.samples[i]);
      const Light over = lightOf(top.samples[i]);
      const double share = std::round(255.0 * over.coverage * opacity) / 255.0;
      std::array<double, 3> expected{};
      for (std::size_t c = 0; c < 3; ++c)
        expected[c] = under.rgb[c] * (1 - share) + over.rgb[c] * share;
      expectNear(picture.samples[i], expected);
      ASSERT_EQ(picture.samples[i].a, 0);
    }
  }
}

TEST(ColourLayers, TheEndsOfOpacityAreExact) {
  const Painted bottom{.tiles = {{kRoot, plain({12, 34, 56, 255})}}};
  const Picture top = plain({210, 120, 3, 255});
  expectPlain(composed({bottom, {.tiles = {{kRoot, top}}, .opacity = 0.0}}, kRoot), {12, 34, 56, 0});
  expectPlain(composed({bottom, {.tiles = {{kRoot, top}}, .opacity = 1.0}}, kRoot), {210, 120, 3, 0});
  // Half of white over black is half the light, not half the byte.
  const Picture half = composed(
      {{.tiles = {{kRoot, plain({0, 0, 0, 255})}}}, {.tiles = {{kRoot, plain({255, 255, 255, 255})}}, .opacity = 0.5}},
      kRoot);
  expectPlain(half, {188, 188, 188, 0});
}

// ---- Night lights

TEST(ColourLayers, NightLightsAreTheirLuminanceBesideTheColour) {
  auto random = geo::seededGenerator();
  for (int round = 0; round < 20; ++round) {
    const Picture ground = randomPicture(random, true);
    const Picture lights = randomPicture(random, round % 2 == 0);
    const double opacity = geo::uniform(random, 0.0, 1.0);
    const Picture picture = composed(
        {{.tiles = {{kRoot, ground}}}, {.tiles = {{kRoot, lights}}, .opacity = opacity, .nightLights = true}}, kRoot);
    for (std::size_t i = 0; i < picture.samples.size(); ++i) {
      const Light l = lightOf(lights.samples[i]);
      const double luminance = 0.2126 * l.rgb[0] + 0.7152 * l.rgb[1] + 0.0722 * l.rgb[2];
      EXPECT_NEAR(picture.samples[i].a, 255.0 * luminance * l.coverage * opacity, 0.51);
      EXPECT_EQ(nightless(picture.samples[i]), nightless(ground.samples[i]));
    }
  }
}

TEST(ColourLayers, TheBrightestLightCountsWhateverLiesOverIt) {
  const Painted bright{.tiles = {{kRoot, plain({255, 255, 255, 255})}}, .opacity = 0.8, .nightLights = true};
  const Painted dim{.tiles = {{kRoot, plain({255, 255, 255, 255})}}, .opacity = 0.2, .nightLights = true};
  const Painted day{.tiles = {{kRoot, plain({1, 2, 3, 255})}}};
  expectPlain(composed({bright, day, dim}, kRoot), {1, 2, 3, 204});
  expectPlain(composed({dim, bright, day}, kRoot), {1, 2, 3, 204});
}

// ---- Mip levels

TEST(TextureFrom, GoesDownToOnePixelAndReducesLightsApart) {
  auto random = geo::seededGenerator();
  const Picture finest = randomPicture(random, false);
  const auto image = textureFrom(finest);
  EXPECT_EQ(image->mips.front().samples, finest.samples);
  EXPECT_EQ(image->mips.back().samples.size(), 1U);
  EXPECT_NE(image->serial, textureFrom(finest)->serial);
  const Picture& half = image->mips[1];
  ASSERT_EQ(half.width, kSide / 2);
  for (int row = 0; row < half.height; ++row) {
    for (int col = 0; col < half.width; ++col) {
      std::array<double, 3> mean{};
      double lights = 0.0;
      for (int i = 0; i < 4; ++i) {
        const Rgba8 p = finest.at(2 * col + (i & 1), 2 * row + (i >> 1));
        for (std::size_t c = 0; c < 3; ++c)
          mean[c] += lightOf(p).rgb[c] / 4.0;  // whatever its lights
        lights += p.a / 4.0;
      }
      expectNear(half.at(col, row), mean);
      EXPECT_NEAR(half.at(col, row).a, lights, 0.51);
    }
  }
}

}  // namespace
}  // namespace tellurion::scene
