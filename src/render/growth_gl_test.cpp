// Memory on the GPU that grows: what is there stays as it was.

#include <epoxy/gl.h>

#include "geo/seed_test.h"
#include "render/geometry_arena.h"
#include "render/synthetic_tiles_test.h"
#include "render/texture_pool.h"
#include "scene/texture_image.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;

constexpr scene::Viewport kSize{96, 72};
constexpr std::uint64_t kMebi = 1u << 20u;

class Growth : public synthetic::GlTest {};

TEST_F(Growth, PicturesStayWhatAndWhereTheyAre) {
  auto random = geo::seededGenerator();
  constexpr int kSide = 130;
  constexpr std::size_t kCount = 400;  // 8 MiB are 93, 24 are 279
  for (const bool compress : {false, true}) {
    if (compress && !readsBlocks()) continue;
    TexturePool pool(512 * kMebi, compress ? PoolKind::compressedColour : PoolKind::colour);
    std::vector<std::shared_ptr<const scene::TextureImage>> images;
    std::vector<TexturePlace> places;
    for (std::size_t i = 0; i < kCount; ++i) {
      const Rgba8 colour{static_cast<std::uint8_t>(random() & 0xF8u), static_cast<std::uint8_t>(random() & 0xFCu),
                         static_cast<std::uint8_t>(i % 2 * 248), 255};
      images.push_back(scene::textureFrom(raster::Raster<Rgba8>(kSide, kSide, colour), compress));
      const TexturePlace* place = pool.upload(*images.back(), 1);
      ASSERT_NE(place, nullptr);
      places.push_back(*place);
    }
    std::uint32_t lastBlock = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const scene::TextureImage& image = *images[i];
      const TexturePlace* place = pool.touch(image.serial, 1);
      ASSERT_EQ(place->block, places[i].block);
      ASSERT_EQ(place->layer, places[i].layer);
      lastBlock = std::max(lastBlock, place->block);
      for (const GLint level : {0, 1, 7}) {
        const int side = std::max(1, kSide >> level);
        raster::Raster<Rgba8> back(side, side);
        glGetTextureSubImage(pool.texture(place->block), level, 0, 0, static_cast<GLint>(place->layer), side, side, 1,
                             GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(back.samples.size() * 4),
                             back.samples.data());
        const Rgba8 wanted = scene::meanOf(image);
        for (const Rgba8& p : back.samples)
          ASSERT_LE(std::max({std::abs(p.r - wanted.r), std::abs(p.g - wanted.g), std::abs(p.b - wanted.b)}), 2) << i;
      }
    }
    EXPECT_EQ(lastBlock, compress ? 0u : 1u);
  }
}

TEST_F(Growth, MeshesToo) {
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  scene::Frame frame;
  frame.light.enabled = false;
  frame.background = {1.0f, 0.0f, 1.0f};
  frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), ellipsoid, 4, 16);
  for (std::size_t i = 0; i < frame.tiles.size(); ++i)
    synthetic::paint(frame, frame.tiles[i], synthetic::plainImage({static_cast<std::uint8_t>(i % 250), 40, 90, 255}));
  std::uint64_t bytes = 0;
  for (const scene::DrawnTile& tile : frame.tiles)
    bytes += bytesOf(*tile.mesh);
  ASSERT_GT(bytes, 9 * kMebi);
  ASSERT_LT(bytes, 32 * kMebi);
  Renderer growing = makeRenderer();
  Renderer inPieces = makeRenderer({.gpuBudgetBytes = 1});  // beyond its budget, chunk by chunk
  const RenderTarget target = makeTarget(kSize);
  for (const double lon : {0.0, 120.0, 240.0}) {
    frame.view = synthetic::viewAt(ellipsoid, 20, lon, 1e7, 0, -90, kSize);
    EXPECT_EQ(growing.draw(frame, target).drawCalls, 1);
    const auto one = readColour(target);
    EXPECT_EQ(inPieces.draw(frame, target).drawCalls, 4);
    EXPECT_EQ(one.samples, readColour(target).samples);
  }
}

}  // namespace
}  // namespace tellurion::render
