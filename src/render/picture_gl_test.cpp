// Which way up a picture is, and what colour.

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using synthetic::viewAt;

constexpr Rgba8 kRed{255, 0, 0, 255};
constexpr Rgba8 kGreen{0, 255, 0, 255};
constexpr Rgba8 kBlue{0, 0, 255, 255};
constexpr Rgba8 kYellow{255, 255, 0, 255};

class Picture : public synthetic::GlTest {
 protected:
  static scene::Frame unlit(const scene::View& view, const std::vector<synthetic::PaintedTile>& tiles) {
    scene::Frame frame;
    frame.view = view;
    frame.light.enabled = false;
    setTiles(frame, tiles);
    return frame;
  }

  static raster::Raster<Rgba8> drawn(const scene::Frame& frame) {
    RenderTarget target = makeTarget(frame.view.viewport);
    makeRenderer().draw(frame, target);
    return readColour(target);
  }

  const geo::Ellipsoid earth_ = geo::earth().ellipsoid;
  const tiling::Tiling geographic_{tiling::Scheme::geographic};
};

TEST_F(Picture, RowZeroIsTheTopNorthIsUpAndEastIsRight) {
  const auto tile = [&](std::uint32_t x, std::uint32_t y, Rgba8 colour) {
    // 45 degrees wide, around (0, 0)
    return synthetic::PaintedTile{.tile = synthetic::gridTile(geographic_, earth_, {1, 0, x, y}, 32),
                                  .colour = synthetic::plainImage(colour)};
  };
  const std::vector tiles{tile(0, 0, kRed), tile(1, 0, kGreen), tile(0, 1, kBlue), tile(1, 1, kYellow)};
  const scene::Viewport size{40, 30};
  const auto corners = [&](double heading) {
    const auto picture = drawn(unlit(viewAt(earth_, 0, 0, 1e6, heading, -90, size), tiles));
    return std::array{picture.at(3, 3), picture.at(36, 3), picture.at(3, 26), picture.at(36, 26)};
  };
  EXPECT_EQ(corners(0), (std::array{kRed, kGreen, kBlue, kYellow}));
  EXPECT_EQ(corners(90), (std::array{kGreen, kYellow, kRed, kBlue}));
}

TEST_F(Picture, TextureRowZeroLiesAtTheTilesTop) {
  raster::Raster<Rgba8> quarters(16, 16);
  for (int row = 0; row < 16; ++row) {
    for (int col = 0; col < 16; ++col)
      quarters.at(col, row) = row < 8 ? (col < 8 ? kRed : kGreen) : (col < 8 ? kBlue : kYellow);
  }
  const synthetic::PaintedTile tile{.tile = synthetic::gridTile(geographic_, earth_, {1, 1, 0, 0}, 16),
                                    .colour = synthetic::imageOf(quarters)};  // 45 to 90 east, 0 to 45 north
  const scene::Viewport size{40, 40};
  const auto picture = drawn(unlit(viewAt(earth_, 22.5, 67.5, 2e6, 0, -90, size), {tile}));
  EXPECT_EQ(picture.at(4, 4), kRed);
  EXPECT_EQ(picture.at(35, 4), kGreen);
  EXPECT_EQ(picture.at(4, 35), kBlue);
  EXPECT_EQ(picture.at(35, 35), kYellow);
}

TEST_F(Picture, TheSkyHasTheBackgroundsColour) {
  for (const int value : {0, 1, 9, 10, 11, 64, 127, 200, 255}) {
    scene::Frame frame = unlit(viewAt(earth_, 0, 0, 100, 0, 60, {4, 4}), {});
    frame.background = {static_cast<float>(value) / 255.0f, 0.0f, 1.0f};
    for (const Rgba8& pixel : drawn(frame).samples)
      EXPECT_EQ(pixel, (Rgba8{static_cast<std::uint8_t>(value), 0, 255, 255}));
  }
}

// 256 tiles whose windows have no size: each shows one texel of one picture.
TEST_F(Picture, WithoutLightEveryByteComesOutUnchanged) {
  constexpr int kSide = 16;
  raster::Raster<Rgba8> all(kSide, kSide);
  for (int i = 0; i < 256; ++i) {
    const auto value = static_cast<std::uint8_t>(i);
    all.at(i % kSide, i / kSide) = {value, static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(i ^ 0x55),
                                    255};
  }
  const auto image = synthetic::imageOf(all);
  std::vector<synthetic::PaintedTile> tiles;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      tiles.push_back({.tile = synthetic::gridTile(geographic_, earth_, {9, 1, 250 + x, 250 + y}, 4), .colour = image});
      tiles.back().colourWindow = {{(static_cast<float>(x) + 0.5f) / kSide, (static_cast<float>(y) + 0.5f) / kSide},
                                   {0.0f, 0.0f}};
    }
  }
  const scene::Viewport size{160, 160};
  const geo::Geodetic centre = geo::geodeticFromDirection(geographic_.direction({1, 258.0 / 512, 258.0 / 512}));
  const scene::View view = viewAt(earth_, centre.lat.degrees(), centre.lon.degrees(), 5e5, 0, -90, size);
  const auto picture = drawn(unlit(view, tiles));
  for (const auto& [tile, colour, window] : tiles) {
    const auto middle = earth_.bodyFromDirection(geographic_.direction(tiling::rootPointIn(tile.id, 0.5, 0.5)));
    const auto pixel = scene::pixelOf(view, middle);
    ASSERT_TRUE(pixel.has_value());
    const Rgba8 texel = all.at(static_cast<int>(tile.id.x - 250), static_cast<int>(tile.id.y - 250));
    EXPECT_EQ(picture.at(static_cast<int>(pixel->x), static_cast<int>(pixel->y)), texel);
  }
}

TEST_F(Picture, GroundWithoutImageryIsNeutralGrey) {
  const std::vector<synthetic::PaintedTile> tiles{{.tile = synthetic::gridTile(geographic_, earth_, {1, 1, 0, 0}, 16)}};
  const auto picture = drawn(unlit(viewAt(earth_, 22.5, 67.5, 1e6, 0, -90, {4, 4}), tiles));
  for (const Rgba8& pixel : picture.samples) {
    EXPECT_EQ(pixel.r, pixel.g);
    EXPECT_EQ(pixel.g, pixel.b);
    EXPECT_GT(pixel.r, 100);
  }
}

/// One picture of 2 x 2 tiles of kSize texels, and tiles cut from it.
class Gutter : public Picture {
 protected:
  static constexpr int kSize = 16;
  static constexpr int kCells = 16;

  Gutter() {
    auto random = geo::seededGenerator();
    whole_ = raster::Raster<Rgba8>(2 * kSize + 2, 2 * kSize + 2);
    for (Rgba8& texel : whole_.samples)
      texel = {static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 128, 255};
  }

  /// The part of the picture that a child shows, with a gutter all round.
  raster::Raster<Rgba8> cut(int x, int y) const {
    raster::Raster<Rgba8> part(kSize + 2, kSize + 2);
    for (int row = 0; row < part.height; ++row) {
      for (int col = 0; col < part.width; ++col)
        part.at(col, row) = whole_.at(col + x * kSize, row + y * kSize);
    }
    return part;
  }

  static scene::TextureWindow windowInside(int size) {
    const float offset = 1.0f / static_cast<float>(size + 2);
    const float scale = static_cast<float>(size) / static_cast<float>(size + 2);
    return {{offset, offset}, {scale, scale}};
  }

  synthetic::PaintedTile tile(const tiling::TileId& id, raster::Raster<Rgba8> picture,
                              const scene::TextureWindow& window) const {
    return {.tile = synthetic::gridTile(geographic_, earth_, id, kCells),
            .colour = synthetic::imageOf(std::move(picture)),
            .colourWindow = window};
  }

  /// The four children, each with the picture that `textured` gives it.
  template <class Textured>
  raster::Raster<Rgba8> children(const Textured& textured) const {
    std::vector<synthetic::PaintedTile> tiles;
    for (int quadrant = 0; quadrant < 4; ++quadrant)
      tiles.push_back(textured(kParent.child(quadrant), quadrant % 2, quadrant / 2));
    return drawn(unlit(view(), tiles));
  }

  /// The same four meshes, each showing its quarter of the whole picture.
  raster::Raster<Rgba8> reference() const {
    const scene::TextureWindow all = windowInside(2 * kSize);
    return children([&](const tiling::TileId& id, int x, int y) {
      const geo::Vec2f half = all.scale * 0.5f;
      return tile(id, whole_, {all.offset + geo::Vec2f(static_cast<float>(x), static_cast<float>(y)) * half, half});
    });
  }

  scene::View view() const {
    return viewAt(earth_, middle().lat.degrees(), middle().lon.degrees(), 6e4, 0, -90, {128, 128});
  }
  geo::Geodetic middle() const {
    return geo::geodeticFromDirection(geographic_.direction(tiling::rootPointIn(kParent, 0.5, 0.5)));
  }

  static int worstDifference(const raster::Raster<Rgba8>& a, const raster::Raster<Rgba8>& b) {
    int worst = 0;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      worst = std::max(worst, std::abs(a.samples[i].r - b.samples[i].r));
      worst = std::max(worst, std::abs(a.samples[i].g - b.samples[i].g));
    }
    return worst;
  }

  static constexpr tiling::TileId kParent{7, 1, 65, 50};
  raster::Raster<Rgba8> whole_;
};

TEST_F(Gutter, TilesCutFromOnePictureShowNoSeam) {
  const auto cuts =
      children([&](const tiling::TileId& id, int x, int y) { return tile(id, cut(x, y), windowInside(kSize)); });
  EXPECT_LE(worstDifference(reference(), cuts), 4);  // a driver may weigh texels with 8 bits
}

// That the test above can fail: without the gutter's texels the seam shows.
TEST_F(Gutter, WithoutItTheSeamShows) {
  const auto bare = children([&](const tiling::TileId& id, int x, int y) {
    auto picture = cut(x, y);
    for (int i = 0; i < kSize + 2; ++i) {
      picture.at(0, i) = picture.at(1, i);
      picture.at(kSize + 1, i) = picture.at(kSize, i);
    }
    return tile(id, std::move(picture), windowInside(kSize));
  });
  EXPECT_GT(worstDifference(reference(), bare), 20);
}

}  // namespace
}  // namespace tellurion::render
