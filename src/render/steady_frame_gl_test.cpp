// A view that needs nothing new costs no allocation: neither for the cut nor for drawing it.

#include "render/allocation_count_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"

namespace tellurion::render {
namespace {

class SteadyFrame : public synthetic::GlTest {};

TEST_F(SteadyFrame, AllocatesNothing) {
  scene::Scene planet;
  const auto elevation =
      std::make_shared<scene::ProceduralSource>(raster::Kind::elevation, planet.tiling, 6, planet.body);
  const auto globe = scene::Globe::fromLayers(planet, {.elevation = {elevation}, .imagery = {}}).value();
  Renderer renderer = makeRenderer();
  constexpr scene::Viewport kSize{320, 240};
  const RenderTarget target = makeTarget(kSize);
  const scene::View view = synthetic::viewAt(planet.body.ellipsoid, 46, 8, 60e3, 20, -35, kSize);
  for (const bool remembers : {false, true}) {
    scene::CutOptions options;
    double time_s = 0.0;
    const auto drawOnce = [&]() -> const scene::Frame& {
      if (remembers) options.time_s = time_s += 1.0 / 60.0;
      const scene::Frame& frame = globe->update(view, options, remembers ? &renderer.residency() : nullptr);
      renderer.draw(frame, target);
      return frame;
    };
    while (true) {
      const scene::Frame& frame = drawOnce();
      if (frame.complete && !frame.morphing) break;
      globe->waitForArrivals(std::chrono::milliseconds(100));
    }
    for (int i = 0; i < 3; ++i)
      drawOnce();
    startCountingAllocations();
    for (int i = 0; i < 10; ++i)
      drawOnce();
    EXPECT_EQ(allocationsCounted(), 0) << (remembers ? "with" : "without") << " a memory of the last frame";
    EXPECT_GT(globe->update(view, options).tiles.size(), 5u);
  }
}

}  // namespace
}  // namespace tellurion::render
