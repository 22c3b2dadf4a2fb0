// However many chunks and blocks of GPU memory a frame lies in, it goes out in four draw calls and is the same picture.

#include <array>
#include <cmath>
#include <limits>

#include "geo/seed_test.h"
#include "render/draw_plan.h"
#include "render/synthetic_tiles_test.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;

constexpr scene::Viewport kSize{96, 72};
constexpr std::uint64_t kMebi = 1u << 20u;

// Shapes that come one after the other, small ones first: each gets a block of its own, of 1024 layers at most, and
// what is left of the budget is for the last.
constexpr std::array kReliefSides{5, 9, 17};
constexpr std::array kPictureSides{4, 6, 8, 10, 12, 14, 16, 18};

class DrawCalls : public synthetic::GlTest, public testing::WithParamInterface<bool> {
 protected:
  static Rgba8 randomTexel(std::mt19937_64& random, std::uint8_t coverage) {
    const auto upToCoverage = [&] { return static_cast<std::uint8_t>(random() % (coverage + 1u)); };
    return {upToCoverage(), upToCoverage(), upToCoverage(), coverage};
  }

  static synthetic::Image randomRelief(std::mt19937_64& random, int side) {
    raster::Raster<Rgba8> texels(side, side);
    for (Rgba8& texel : texels.samples)
      texel = {static_cast<std::uint8_t>(88 + random() % 80), static_cast<std::uint8_t>(88 + random() % 80),
               static_cast<std::uint8_t>(88 + random() % 80), 255};
    return synthetic::imageOf(std::move(texels));
  }

  /// The Earth from a random place by a low sun; each tile with a random mesh, relief and pictures of the first
  /// `shapes` shapes: none, one that covers all or not, and night lights.
  static scene::Frame randomEarth(std::mt19937_64& random, const std::vector<std::vector<scene::DrawnTile>>& meshes,
                                  std::size_t shapes) {
    scene::Frame frame;
    frame.view = synthetic::viewAt(geo::earth().ellipsoid, geo::uniform(random, -80, 80),
                                   geo::uniform(random, -180, 180), geo::uniform(random, 2e6, 1e7), 0, -90, kSize);
    frame.light.toSun_body = geo::normalize(
        geo::Vec3(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1)));
    frame.looks = {{}, {.opacity = 0.6}, {.role = scene::LayerRole::nightLights}};
    const auto side = [&](auto sides) { return sides.at(random() % std::min(shapes, sides.size())); };
    for (std::size_t i = 0; i < meshes.front().size(); ++i) {
      scene::DrawnTile tile = meshes.at(random() % meshes.size()).at(i);
      if (random() % 4 != 0) tile.relief = randomRelief(random, side(kReliefSides));
      tile.firstPicture = static_cast<std::uint32_t>(frame.pictures.size());
      const std::array<std::vector<std::uint32_t>, 5> stacks{{{}, {0}, {0}, {0, 2}, {0, 1, 2}}};
      for (const std::uint32_t layer : stacks.at(random() % stacks.size())) {
        const Rgba8 texel = randomTexel(random, layer == 0 ? 255 : 200);
        frame.pictures.push_back({.image = synthetic::plainImage(texel, side(kPictureSides)), .layer = layer});
        ++tile.pictureCount;
      }
      frame.tiles.push_back(std::move(tile));
    }
    return frame;
  }

  /// The nearest of all tiles at each pixel, where each was drawn alone.
  static raster::Raster<Rgba8> composed(const scene::Frame& frame, Renderer& renderer, const RenderTarget& target) {
    scene::Frame one = frame;
    raster::Raster<Rgba8> picture(kSize.width, kSize.height);
    std::vector<float> nearest(picture.samples.size(), std::numeric_limits<float>::infinity());
    for (const scene::DrawnTile& tile : frame.tiles) {
      one.tiles = {tile};
      EXPECT_EQ(renderer.draw(one, target).drawCalls, 1);
      const auto colour = readColour(target);
      const auto distance = readDistance(target, frame.view);
      for (std::size_t i = 0; i < nearest.size(); ++i) {
        const bool isSky = std::isnan(distance.samples[i]);
        if (isSky ? std::isinf(nearest[i]) : distance.samples[i] <= nearest[i]) picture.samples[i] = colour.samples[i];
        if (!isSky) nearest[i] = std::min(nearest[i], distance.samples[i]);
      }
    }
    return picture;
  }
};
INSTANTIATE_TEST_SUITE_P(Shaders, DrawCalls, testing::Bool(), [](const auto& asOnAnyGpu) {
  return std::string(asOnAnyGpu.param ? "ofGpus" : "ofThisDriver");
});

TEST_P(DrawCalls, AreFourAtMostOnALongTourThroughManyChunksAndBlocks) {
  auto random = geo::seededGenerator();
  // 7 to 9 MiB of meshes for a share of 6, so the arena takes what it must in further chunks.
  const tiling::Tiling tiling(tiling::Scheme::cube);
  std::vector<std::vector<scene::DrawnTile>> meshes;
  for (const int cells : {72, 76, 80})
    meshes.push_back(synthetic::wholeBody(tiling, geo::earth().ellipsoid, 1, cells));
  Renderer crowded = makeRenderer({.gpuBudgetBytes = 16 * kMebi, .asOnAnyGpu = GetParam()});
  Renderer roomy = makeRenderer({.asOnAnyGpu = GetParam()});
  const RenderTarget target = makeTarget(kSize);
  int withMost = 0;
  for (std::size_t stop = 0; stop < 16; ++stop) {
    const scene::Frame frame = randomEarth(random, meshes, 1 + stop);
    const RenderStatistics drawn = crowded.draw(frame, target);
    ASSERT_EQ(drawn.tilesDrawn, static_cast<int>(frame.tiles.size()));
    ASSERT_EQ(drawn.tilesWithoutRoom, 0);
    ASSERT_LE(drawn.drawCalls, static_cast<int>(kMostDrawCalls));
    withMost += drawn.drawCalls == static_cast<int>(kMostDrawCalls) ? 1 : 0;
    const auto picture = readColour(target);
    ASSERT_EQ(picture.samples, composed(frame, roomy, target).samples) << stop;
  }
  EXPECT_GT(withMost, 12) << "few chunks and blocks are in use";
}

}  // namespace
}  // namespace tellurion::render
