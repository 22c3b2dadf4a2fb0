// GPU memory, draw calls, moves: what the renderer promises besides the picture.

#include "render/renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstdlib>

#include "geo/body.h"
#include "render/allocation_count_test.h"
#include "render/synthetic_tiles_test.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using synthetic::viewAt;

constexpr scene::Viewport kSize{96, 72};
constexpr std::uint64_t kMebi = 1u << 20u;

class RendererTest : public synthetic::GlTest {
 protected:
  /// All of Earth in tiles with a texture each of `side` pixels, unlit.
  static scene::Frame earth(int side, int level = 2) {
    const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
    scene::Frame frame;
    frame.view = viewAt(ellipsoid, 20, 30, 1e7, 0, -90, kSize);
    frame.light.enabled = false;
    frame.background = {1.0f, 0.0f, 1.0f};
    frame.tiles = synthetic::wholeBody(tiling::Tiling(tiling::Scheme::cube), ellipsoid, level, 16);
    for (std::size_t i = 0; i < frame.tiles.size(); ++i) {
      const auto grey = static_cast<std::uint8_t>(10 + i % 240);
      synthetic::paint(frame, frame.tiles[i], synthetic::plainImage({grey, 40, grey, 255}, side));
      frame.tiles[i].relief = synthetic::plainImage({128, 128, 128, 255}, 17);
    }
    return frame;
  }

  static int worstDifference(const raster::Raster<Rgba8>& a, const raster::Raster<Rgba8>& b) {
    int worst = 0;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      worst = std::max({worst, std::abs(a.samples[i].r - b.samples[i].r), std::abs(a.samples[i].g - b.samples[i].g),
                        std::abs(a.samples[i].b - b.samples[i].b)});
    }
    return worst;
  }
};

TEST_F(RendererTest, StatisticsTellWhatWasDrawn) {
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  const scene::Frame frame = earth(16);
  const RenderStatistics first = renderer.draw(frame, target);
  EXPECT_EQ(first.tilesDrawn, 96);
  EXPECT_EQ(first.uploads, 3 * 96);
  EXPECT_EQ(first.tilesWithoutRoom, 0);
  EXPECT_EQ(first.drawCalls, 1);
  std::int64_t triangles = 0;
  for (const scene::DrawnTile& tile : frame.tiles) {
    triangles += tile.mesh->interior.count / 3;
    for (const scene::IndexRange& edge : tile.mesh->fineEdge)
      triangles += edge.count / 3;
  }
  EXPECT_EQ(first.triangles, triangles);
  const RenderStatistics second = renderer.draw(frame, target);
  EXPECT_EQ(second.uploads, 0);
  EXPECT_EQ(second.triangles, first.triangles);
  EXPECT_EQ(second.gpuBytes, first.gpuBytes);
}

TEST_F(RendererTest, ASharedTextureIsCopiedOnce) {
  scene::Frame frame = earth(16);
  for (scene::DrawnTile& tile : frame.tiles) {
    tile.firstPicture = 0;
    tile.relief = nullptr;
  }
  RenderTarget target = makeTarget(kSize);
  EXPECT_EQ(makeRenderer().draw(frame, target).uploads, 96 + 1);
}

TEST_F(RendererTest, EmptyFramesAndTilesWithoutAMeshAreSky) {
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  scene::Frame frame = earth(16);
  for (scene::DrawnTile& tile : frame.tiles)
    tile.mesh = nullptr;
  for (int round = 0; round < 2; ++round) {
    const RenderStatistics drawn = renderer.draw(frame, target);
    EXPECT_EQ(drawn.tilesDrawn, 0);
    EXPECT_EQ(drawn.drawCalls, 0);
    for (const Rgba8& pixel : readColour(target).samples)
      EXPECT_EQ(pixel, (Rgba8{255, 0, 255, 255}));
    frame.tiles.clear();
  }
}

TEST_F(RendererTest, ASteadyStateAllocatesNothing) {
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  scene::Frame frame = earth(16);
  for (int i = 0; i < 3; ++i)
    renderer.draw(frame, target);
  finish();
  for (int i = 0; i < 10; ++i) {
    frame.view = viewAt(geo::earth().ellipsoid, 20 + i, 30, 1e7, 0, -90, kSize);
    startCountingAllocations();
    renderer.draw(frame, target);
    EXPECT_EQ(allocationsCounted(), 0);
  }
}

// Textures that find no room are drawn in their mean colour: the same here, where each is of one colour.
TEST_F(RendererTest, ATinyBudgetStillShowsAllTheGround) {
  const scene::Frame frame = earth(64);
  RenderTarget target = makeTarget(kSize);
  makeRenderer().draw(frame, target);
  const auto whole = readColour(target);
  for (const std::uint64_t budget : {std::uint64_t{0}, std::uint64_t{1}, kMebi / 4, kMebi, 4 * kMebi}) {
    Renderer renderer = makeRenderer({.gpuBudgetBytes = budget});
    for (int round = 0; round < 2; ++round) {
      const RenderStatistics drawn = renderer.draw(frame, target);
      EXPECT_EQ(drawn.tilesDrawn, 96);
      EXPECT_LE(worstDifference(readColour(target), whole), 1) << budget;
      // All meshes are needed: 96 of about 17 KiB, and some spare of the growing arena.
      EXPECT_LE(drawn.gpuBytes, budget + 4 * kMebi);
    }
  }
}

TEST_F(RendererTest, BytesStayWithinTheBudgetHoweverMuchPassesBy) {
  constexpr std::uint64_t kBudget = 24 * kMebi;
  Renderer renderer = makeRenderer({.gpuBudgetBytes = kBudget});
  RenderTarget target = makeTarget(kSize);
  int uploads = 0;
  for (int i = 0; i < 30; ++i) {  // 96 new meshes and textures each time, about 4 MiB
    const scene::Frame frame = earth(64);
    const RenderStatistics drawn = renderer.draw(frame, target);
    uploads += drawn.uploads;
    EXPECT_EQ(drawn.tilesWithoutRoom, 0) << i;
    EXPECT_LE(drawn.gpuBytes, kBudget) << i;
  }
  EXPECT_EQ(uploads, 30 * 3 * 96);
}

TEST_F(RendererTest, TexturesOfManyShapesShareTheBudget) {
  constexpr std::uint64_t kBudget = 16 * kMebi;
  Renderer renderer = makeRenderer({.gpuBudgetBytes = kBudget});
  RenderTarget target = makeTarget(kSize);
  for (const int side : {256, 130, 66, 34, 18, 256, 18, 7, 256}) {
    const scene::Frame frame = earth(side, 0);
    const RenderStatistics drawn = renderer.draw(frame, target);
    EXPECT_EQ(drawn.tilesDrawn, 6);
    // One layer a shape may come on top.
    EXPECT_LE(drawn.gpuBytes, kBudget + kMebi) << side;
  }
}

TEST_F(RendererTest, ComesBackWithWhatWasDrivenOut) {
  Renderer renderer = makeRenderer({.gpuBudgetBytes = 8 * kMebi});
  RenderTarget target = makeTarget(kSize);
  const scene::Frame first = earth(64);
  renderer.draw(first, target);
  const auto picture = readColour(target);
  for (int i = 0; i < 5; ++i)
    renderer.draw(earth(64), target);
  EXPECT_GT(renderer.draw(first, target).uploads, 0);
  EXPECT_LE(worstDifference(readColour(target), picture), 1);
}

TEST_F(RendererTest, MovedRenderersAndTargetsGoOn) {
  const scene::Frame frame = earth(16);
  Renderer first = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  first.draw(frame, target);
  const auto picture = readColour(target);
  Renderer second = std::move(first);
  EXPECT_EQ(second.draw(frame, target).uploads, 0);
  Renderer third = makeRenderer();
  third = std::move(second);
  RenderTarget moved = std::move(target);
  EXPECT_EQ(third.draw(frame, moved).uploads, 0);
  EXPECT_EQ(readColour(moved).samples, picture.samples);
  target = makeTarget({8, 8});
  moved = std::move(target);
  EXPECT_EQ(moved.size().width, 8);
  third.draw(frame, moved);
  EXPECT_EQ(readColour(moved).samples.size(), 64u);
}

TEST_F(RendererTest, StateLeftByOthersDoesNotMatter) {
  const scene::Frame frame = earth(16);
  RenderTarget large = makeTarget(kSize);
  RenderTarget small = makeTarget({16, 12});
  Renderer one = makeRenderer();
  Renderer other = makeRenderer();
  one.draw(frame, large);
  const auto picture = readColour(large);
  other.draw(frame, small);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  glEnable(GL_BLEND);
  glEnable(GL_SCISSOR_TEST);
  glScissor(0, 0, 3, 3);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_FALSE);
  glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
  glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  one.draw(frame, large);
  EXPECT_EQ(readColour(large).samples, picture.samples);
}

TEST_F(RendererTest, TargetsOfImpossibleSizesAreFailures) {
  const scene::Viewport most = RenderTarget::largest();
  for (const scene::Viewport size :
       {scene::Viewport{0, 10}, {10, 0}, {-1, 10}, {most.width + 1, 1}, {1, most.height + 1}}) {
    const auto target = RenderTarget::create(size);
    ASSERT_FALSE(target.has_value());
    EXPECT_EQ(target.error().code, io::Failure::Code::invalidArgument);
    EXPECT_NE(io::describe(target.error()).find(std::to_string(size.width) + "x"), std::string::npos);
  }
  EXPECT_TRUE(RenderTarget::create({1, 1}).has_value());
}

TEST_F(RendererTest, ContextsMove) {
  HeadlessContext moved = std::move(*context());
  EXPECT_TRUE(checkCurrentContext().has_value());
  *context() = std::move(moved);
  EXPECT_TRUE(checkCurrentContext().has_value());
  EXPECT_FALSE(describeCurrentContext().empty());
}

}  // namespace
}  // namespace tellurion::render
