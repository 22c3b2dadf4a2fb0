// Pictures of layers against the definition in double precision: the finest data set that has data, in linear light.
#include "scene/colour_layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "geo/seed_test.h"
#include "scene/texture_image.h"

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
  std::set<TileId> failing = {};
  std::set<TileId> missing = {};
  int maxLevel = 2;
};

/// One layer of these data sets.
struct Stack {
  std::shared_ptr<LoadLedger> ledger = std::make_shared<LoadLedger>();
  ColourLayers::Layer layer{.sets = {}, .pixels = kPixels};

  explicit Stack(const std::vector<Painted>& painted, bool isStrength = false) {
    layer.isStrength = isStrength;
    for (const Painted& p : painted) {
      auto source = std::make_shared<PaintedSource>(p.maxLevel);
      source->tiles = p.tiles;
      source->failing = p.failing;
      source->missing = p.missing;
      layer.sets.push_back(std::make_shared<LayerTiles>(source, 1u << 20u, ledger));
    }
  }
  /// As a Globe asks for it: the tiles over it first.
  LayerPicture picture(const TileId& id) const {
    const ColourLayers layers({layer});
    std::vector<LayerPicture> pictures;
    for (int level = 0; level <= id.level; ++level)
      pictures = layers.pictures(id.ancestor(level), pictures);
    return pictures.at(0);
  }
};

/// The finest level of a tile's picture; empty: there is none.
Picture pictureOf(const std::vector<Painted>& painted, const TileId& id) {
  const LayerPicture picture = Stack(painted).picture(id);
  return picture.image ? picture.image->mips.front() : Picture();
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

/// Off by one byte at most: of the colour, or (at small coverage) of the coverage.
void expectNear(Rgba8 actual, const std::array<double, 3>& expected, double tolerance = 1.01) {
  EXPECT_NEAR(actual.r, byteOf(expected[0]), tolerance);
  EXPECT_NEAR(actual.g, byteOf(expected[1]), tolerance);
  EXPECT_NEAR(actual.b, byteOf(expected[2]), tolerance);
}

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

// ---- Which tiles

TEST(ColourLayers, ATileOfItsOwnOrTheNearestAbove) {
  const Stack stack({{.tiles = {{kRoot, plain({10, 20, 30, 255})}, {kChild, plain({40, 50, 60, 255})}}}});
  const LayerPicture root = stack.picture(kRoot);
  expectPlain(root.image->mips.front(), {10, 20, 30, 255});
  EXPECT_TRUE(root.isOwn && root.finerBelow && root.image->isOpaque);
  const LayerPicture child = stack.picture(kChild);
  expectPlain(child.image->mips.front(), {40, 50, 60, 255});
  EXPECT_TRUE(child.isOwn && !child.finerBelow);
  EXPECT_EQ(child.level, 1);
  const LayerPicture grandchild = stack.picture(kGrandchild);
  expectPlain(grandchild.image->mips.front(), {40, 50, 60, 255});
  EXPECT_TRUE(!grandchild.isOwn && !grandchild.finerBelow);
  EXPECT_EQ(grandchild.level, 1);
}

TEST(ColourLayers, LayersAreApart) {
  const Stack fine({{.tiles = {{kRoot, plain({1, 1, 1, 255})}, {kChild, plain({0, 200, 0, 255})}}}});
  const Stack coarse({{.tiles = {{kRoot, plain({200, 0, 0, 255})}}}});
  const ColourLayers layers({fine.layer, coarse.layer});
  const auto root = layers.pictures(kRoot, {});
  const auto child = layers.pictures(kChild, root);
  ASSERT_EQ(child.size(), 2U);
  EXPECT_EQ(child[0].level, 1);
  EXPECT_EQ(child[1].level, 0);
  EXPECT_EQ(child[1].image, root[1].image);
}

TEST(ColourLayers, WithoutDataThereIsNoPicture) {
  EXPECT_EQ(Stack({Painted{}}).picture(kRoot).image, nullptr);
  const Stack hole({{.tiles = {{kRoot, plain({9, 9, 9, 255})}, {kChild, plain({9, 9, 9, 0})}}}});
  EXPECT_EQ(hole.picture(kChild).image, nullptr);
  EXPECT_EQ(hole.picture(kGrandchild).image, nullptr);
  EXPECT_TRUE(ColourLayers({}).pictures(kRoot, {}).empty());
}

// ---- Missing tiles

TEST(ColourLayers, ATileThatFailsIsItsParents) {
  for (const bool fails : {true, false}) {
    Painted hurt{.tiles = {{kRoot, plain({70, 80, 90, 255})}}};
    (fails ? hurt.failing : hurt.missing).insert(kChild);
    const Stack stack({hurt});
    const LayerPicture picture = stack.picture(kChild);
    ASSERT_NE(picture.image, nullptr);
    EXPECT_EQ(picture.image->mips.front().at(3, 3), (Rgba8{70, 80, 90, 255}));
    EXPECT_FALSE(picture.finerBelow);
    for (int i = 0; i < 3; ++i)
      stack.picture(kChild);
    EXPECT_EQ(stack.ledger->takeFailures().size(), 1U);
  }
}

// ---- Several data sets in a layer

TEST(ColourLayers, TheFinestDataSetThatHasDataWinsAtEachSample) {
  auto random = geo::seededGenerator();
  for (int round = 0; round < 20; ++round) {
    const Picture world = randomPicture(random, true);
    Picture local = randomPicture(random, true);
    for (Rgba8& p : local.samples)
      p.a = random() % 2 == 0 ? 0 : 255;
    const Painted coarse{.tiles = {{kRoot, world}}, .maxLevel = 0};
    const Painted fine{.tiles = {{kRoot, plain({})}, {kChild, local}}, .maxLevel = 1};
    for (const bool fineFirst : {true, false}) {
      const auto sets = fineFirst ? std::vector{fine, coarse} : std::vector{coarse, fine};
      EXPECT_EQ(pictureOf(sets, kRoot).samples, world.samples);
      const Picture child = pictureOf(sets, kChild);
      for (int row = 1; row <= kPixels; ++row) {
        for (int col = 1; col <= kPixels; ++col) {
          if (local.at(col, row).a == 255) {
            EXPECT_EQ(child.at(col, row), local.at(col, row));
          } else {
            expectNear(child.at(col, row), enlargedAt(world, 1, kChild, col, row).rgb);
          }
          EXPECT_EQ(child.at(col, row).a, 255);
        }
      }
    }
  }
}

// Of one level here, but one of them goes deeper elsewhere.
TEST(ColourLayers, OfTwoDataSetsOfALevelTheDeeperWinsElseTheLater) {
  const Painted deep{.tiles = {{kRoot, plain({1, 1, 1, 255})}}, .maxLevel = 5};
  const Painted flat{.tiles = {{kRoot, plain({2, 2, 2, 255})}}, .maxLevel = 3};
  const Painted alike{.tiles = {{kRoot, plain({3, 3, 3, 255})}}, .maxLevel = 3};
  expectPlain(pictureOf({deep, flat}, kRoot), {1, 1, 1, 255});
  expectPlain(pictureOf({flat, deep}, kRoot), {1, 1, 1, 255});
  expectPlain(pictureOf({flat, alike}, kRoot), {3, 3, 3, 255});
  expectPlain(pictureOf({alike, flat}, kRoot), {2, 2, 2, 255});
}

// ---- Enlarging

TEST(ColourLayers, AnEnlargedAncestorIsBilinearInLinearLight) {
  auto random = geo::seededGenerator();
  const Painted own{.tiles = {{kRoot, plain({})}, {kChild, plain({})}, {kGrandchild, plain({})}}};
  for (int round = 0; round < 20; ++round) {
    const Picture ancestor = randomPicture(random, true);
    for (const TileId& id : {kChild, kGrandchild}) {
      const Picture picture = pictureOf({own, {.tiles = {{kRoot, ancestor}}, .maxLevel = 0}}, id);
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
  const Painted own{.tiles = {{kRoot, plain({})}, {kChild, plain({0, 0, 0, 0})}}};
  const Picture picture = pictureOf({own, {.tiles = {{kRoot, half}}, .maxLevel = 0}}, kChild);
  for (const Rgba8& p : picture.samples)
    EXPECT_EQ(p.g, 0);
  EXPECT_EQ(picture.at(1, 4), (Rgba8{250, 0, 0, 255}));  // over the ancestor's columns 4.75..5
  EXPECT_EQ(picture.at(8, 4).a, 0);
}

// ---- Night lights

TEST(ColourLayers, NightLightsAreTheirLuminance) {
  auto random = geo::seededGenerator();
  for (int round = 0; round < 20; ++round) {
    const Picture lights = randomPicture(random, round % 2 == 0);
    const LayerPicture picture = Stack({{.tiles = {{kRoot, lights}}}}, true).picture(kRoot);
    for (std::size_t i = 0; i < lights.samples.size(); ++i) {
      const Light l = lightOf(lights.samples[i]);
      const double luminance = 0.2126 * l.rgb[0] + 0.7152 * l.rgb[1] + 0.0722 * l.rgb[2];
      const Rgba8 lamp = picture.image->mips.front().samples[i];
      EXPECT_NEAR(lamp.a, 255.0 * luminance * l.coverage, 0.51);
      EXPECT_EQ(lamp, (Rgba8{0, 0, 0, lamp.a}));
    }
  }
  EXPECT_EQ(Stack({{.tiles = {{kRoot, plain({0, 0, 0, 255})}}}}, true).picture(kRoot).image, nullptr);
}

TEST(ColourLayers, CompressedPicturesSayTheSame) {
  const Stack stack({{.tiles = {{kRoot, plain({40, 50, 60, 255})}, {kRoot.child(0), plain({40, 50, 60, 128})}}}});
  for (const tiling::TileId& id : {kRoot, kRoot.child(0)}) {
    const auto picture = ColourLayers({stack.layer}, true).pictures(id, {}).at(0);
    const auto plainOne = ColourLayers({stack.layer}).pictures(id, {}).at(0);
    ASSERT_TRUE(picture.image && plainOne.image);
    EXPECT_TRUE(picture.image->mips.empty());
    EXPECT_EQ(picture.image->isOpaque, plainOne.image->isOpaque);
    ASSERT_EQ(picture.image->blocks.size(), plainOne.image->mips.size());
    for (std::size_t level = 0; level < plainOne.image->mips.size(); ++level) {
      EXPECT_EQ(picture.image->blocks[level].width, plainOne.image->mips[level].width);
      EXPECT_EQ(picture.image->blocks[level].height, plainOne.image->mips[level].height);
    }
    const Rgba8 mean = meanOf(*picture.image);
    const Rgba8 wanted = meanOf(*plainOne.image);
    EXPECT_NEAR(mean.r, wanted.r, 4);
    EXPECT_NEAR(mean.g, wanted.g, 2);
    EXPECT_NEAR(mean.b, wanted.b, 4);
    EXPECT_EQ(mean.a, wanted.a);
  }
}

// ---- Textures

TEST(TextureFrom, GoesDownToOnePixelAndIsMultipliedWithItsCoverage) {
  auto random = geo::seededGenerator();
  for (const bool isOpaque : {true, false}) {
    const Picture finest = randomPicture(random, isOpaque);
    const auto image = textureFrom(finest);
    EXPECT_EQ(image->isOpaque, isOpaque);
    if (isOpaque) {
      EXPECT_EQ(image->mips.front().samples, finest.samples);
    }
    EXPECT_EQ(image->mips.back().samples.size(), 1U);
    EXPECT_NE(image->serial, textureFrom(finest)->serial);
    const Picture& whole = image->mips[0];
    const Picture& half = image->mips[1];
    ASSERT_EQ(half.width, kSide / 2);
    const auto multiplied = [](Rgba8 p) {
      Light l = lightOf(p);
      for (double& c : l.rgb)
        c *= l.coverage;
      return l;
    };
    for (int row = 0; row < half.height; ++row) {
      for (int col = 0; col < half.width; ++col) {
        Light mean;
        for (int i = 0; i < 4; ++i) {
          const Light p = multiplied(finest.at(2 * col + (i & 1), 2 * row + (i >> 1)));
          expectNear(whole.at(2 * col + (i & 1), 2 * row + (i >> 1)), p.rgb, 0.6);
          for (std::size_t c = 0; c < 3; ++c)
            mean.rgb[c] += p.rgb[c] / 4.0;
          mean.coverage += p.coverage / 4.0;
        }
        expectNear(half.at(col, row), mean.rgb, 1.6);  // rounded twice
        EXPECT_NEAR(half.at(col, row).a, 255.0 * mean.coverage, 0.51);
      }
    }
  }
}

}  // namespace
}  // namespace tellurion::scene
