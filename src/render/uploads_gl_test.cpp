// A globe that knows what is on the GPU: copies stay within the bytes of a frame, whatever has come meanwhile.

#include "render/synthetic_tiles_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"

namespace tellurion::render {
namespace {

constexpr scene::Viewport kSize{640, 480};
constexpr std::uint64_t kMebi = 1u << 20u;
constexpr std::uint64_t kAtOnce = ~std::uint64_t{0};

class Uploads : public synthetic::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    const scene::Scene planet;
    const auto heights = std::make_shared<scene::ProceduralSource>(raster::Kind::elevation, planet.tiling, 6);
    const auto pictures = std::make_shared<scene::ProceduralSource>(raster::Kind::imagery, planet.tiling, 6);
    globe = scene::Globe::fromLayers(planet, {.elevation = {heights}, .imagery = {{.source = pictures}}},
                                     {.cpuCacheBytes = 1024 * kMebi})
                .value();
    for (double t = 0.0; !globe->update(view, {.time_s = t}).complete; t += 1.0)  // what is out of view too
      globe->waitForArrivals(std::chrono::milliseconds(100));
  }

  /// Draws until the frame is complete: the bytes of each draw.
  std::vector<std::uint64_t> drawAll(Renderer& renderer, std::uint64_t budget) {
    const RenderTarget target = makeTarget(kSize);
    std::vector<std::uint64_t> bytes;
    globe->update(view);  // forgets what was drawn
    bool complete = false;
    while (!complete && bytes.size() < 500) {
      time_s += 1.0;
      const scene::Frame& frame =
          globe->update(view, {.time_s = time_s, .copies_bytes = budget}, &renderer.residency());
      complete = frame.complete;
      const RenderStatistics drawn = renderer.draw(frame, target);
      EXPECT_EQ(drawn.tilesDrawn, static_cast<int>(frame.tiles.size()));
      EXPECT_EQ(drawn.uploads > 0, drawn.uploadBytes > 0);
      bytes.push_back(drawn.uploadBytes);
    }
    EXPECT_TRUE(complete);
    return bytes;
  }

  const scene::View view = synthetic::viewAt(geo::earth().ellipsoid, 30, 15, 200e3, 0, -50, kSize);
  std::unique_ptr<scene::Globe> globe;
  double time_s = 0.0;
};

TEST_F(Uploads, StayWithinTheBytesOfAFrame) {
  Renderer whole = makeRenderer();
  const auto atOnce = drawAll(whole, kAtOnce);
  ASSERT_GT(atOnce[0], 5 * kMebi);
  Renderer renderer = makeRenderer();
  const auto bytes = drawAll(renderer, 2 * kMebi);
  std::uint64_t sum = 0;
  for (const std::uint64_t one : bytes) {
    sum += one;
    EXPECT_LE(one, 2 * kMebi);
  }
  EXPECT_GE(sum, atOnce[0]);
  EXPECT_GE(bytes.size(), atOnce[0] / (2 * kMebi));
  std::printf("%.1f MiB at once, %.1f MiB in %zu frames\n", double(atOnce[0]) / kMebi, double(sum) / kMebi,
              bytes.size());
}

TEST_F(Uploads, WhatAloneIsMoreThanTheBudgetComesAlone) {
  Renderer renderer = makeRenderer();
  const auto bytes = drawAll(renderer, 1);
  // Four tiles of a split, or the roots: a mesh, and a picture of 258 pixels with a relief, each with its mip levels.
  for (std::size_t i = 0; i < bytes.size(); ++i)
    EXPECT_LE(bytes[i], (i == 0 ? 6 : 4) * 700 * 1024u) << i;
}

TEST_F(Uploads, MemoryForHalfOfTheViewIsNoReasonToWaitForEver) {
  for (const std::uint64_t memory : {std::uint64_t{1}, 8 * kMebi, 24 * kMebi}) {
    Renderer renderer = makeRenderer({.gpuBudgetBytes = memory});
    for (const std::uint64_t budget : {std::uint64_t{1}, kMebi})
      drawAll(renderer, budget);
  }
}

}  // namespace
}  // namespace tellurion::render
