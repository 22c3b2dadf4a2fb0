// A view that needs nothing new costs no allocation: neither for the cut nor for drawing it.

#include <cmath>

#include "render/allocation_count_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"

namespace tellurion::render {
namespace {

constexpr scene::Viewport kSize{320, 240};

/// A planet of mountains under a picture, drawn with or without a memory of the last frame.
class SteadyFrame : public synthetic::GlTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    synthetic::GlTest::SetUp();
    if (IsSkipped()) return;
    const auto source = [&](raster::Kind kind) {
      return std::make_shared<scene::ProceduralSource>(kind, planet_.tiling, 6, planet_.body);
    };
    globe_ = scene::Globe::fromLayers(planet_, {.elevation = {source(raster::Kind::elevation)},
                                                .imagery = {{.source = source(raster::Kind::imagery)}}})
                 .value();
    renderer_.emplace(makeRenderer());
    target_.emplace(makeTarget(kSize));
  }

  const scene::Frame& drawOnce(const scene::View& view) {
    scene::CutOptions options;
    if (GetParam()) options.time_s = time_s_ += 1.0 / 60.0;
    const scene::Frame& frame = globe_->update(view, options, GetParam() ? &renderer_->residency() : nullptr);
    drawn_ = renderer_->draw(frame, *target_);
    return frame;
  }
  void drawUntilSettled(const scene::View& view) {
    while (true) {
      const scene::Frame& frame = drawOnce(view);
      if (frame.complete && !frame.morphing) return;
      globe_->waitForArrivals(std::chrono::milliseconds(100));
    }
  }
  scene::View viewAt(double lat, double heading) const {
    return synthetic::viewAt(planet_.body.ellipsoid, lat, 8, 60e3, heading, -35, kSize);
  }

  scene::Scene planet_;
  std::unique_ptr<scene::Globe> globe_;
  std::optional<Renderer> renderer_;
  std::optional<RenderTarget> target_;
  RenderStatistics drawn_;
  double time_s_ = 0.0;
};
INSTANTIATE_TEST_SUITE_P(Memory, SteadyFrame, testing::Bool(), [](const auto& remembers) {
  return std::string(remembers.param ? "ofTheLastFrame" : "ofNothing");
});

TEST_P(SteadyFrame, AllocatesNothing) {
  const scene::View view = viewAt(46, 20);
  drawUntilSettled(view);
  for (int i = 0; i < 3; ++i)
    drawOnce(view);
  startCountingAllocations();
  for (int i = 0; i < 10; ++i)
    drawOnce(view);
  EXPECT_EQ(allocationsCounted(), 0);
  const scene::Frame& frame = drawOnce(view);
  EXPECT_GT(frame.tiles.size(), 5u);
  EXPECT_GT(frame.tiles.front().pictureCount, 0u);
}

/// Nor does an eye that flies, climbs and turns, from the first round on that asks for nothing and copies nothing.
TEST_P(SteadyFrame, AllocatesNothingInAFlightOverLoadedGround) {
  constexpr int kFrames = 90;
  constexpr int kRounds = 30;
  const auto onTheWay = [&](int frame) {
    const double turn = 2.0 * geo::kPi * frame / kFrames;
    return synthetic::viewAt(planet_.body.ellipsoid, 46.0 + 0.2 * std::sin(turn), 8.0 - 0.3 * std::sin(2.0 * turn),
                             60e3 + 30e3 * std::sin(turn), 20.0 + 25.0 * std::cos(turn), -35, kSize);
  };
  int allocations = 0;
  int changes = 0;
  bool loads = true;
  for (int i = 0; i < kRounds && loads; ++i) {
    loads = false;
    allocations = changes = 0;
    std::size_t tiles = 0;
    for (int k = 0; k < kFrames; ++k) {
      startCountingAllocations();
      const std::size_t now = drawOnce(onTheWay(k)).tiles.size();
      allocations += allocationsCounted();
      changes += now != tiles ? 1 : 0;
      tiles = now;
      loads = loads || drawn_.uploads > 0;
      // What lies ahead has to come before the eye has passed it, or it is let go of, and asked for in the next round.
      if (globe_->waitForArrivals(std::chrono::seconds(1))) loads = true;
    }
  }
  EXPECT_FALSE(loads) << "after " << kRounds << " rounds";
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(changes, 4) << "the eye hardly moves";
}

}  // namespace
}  // namespace tellurion::render
