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
    renderer_->draw(frame, *target_);
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

/// Nor does an eye that flies and turns over what is loaded already, where nothing is remembered: no tile fades then.
TEST_P(SteadyFrame, AllocatesNothingInAFlightOverLoadedGround) {
  if (GetParam()) GTEST_SKIP() << "of frames that remember the last one, some allocate";
  constexpr int kFrames = 60;
  const auto onTheWay = [&](int frame) {
    const double turn = 2.0 * geo::kPi * frame / kFrames;
    return viewAt(46.0 + 0.2 * std::sin(turn), 20.0 + 15.0 * std::cos(turn));
  };
  const auto round = [&] {
    std::size_t tiles = 0;
    int changes = 0;
    for (int i = 0; i < kFrames; ++i) {
      const std::size_t now = drawOnce(onTheWay(i)).tiles.size();
      changes += now != tiles ? 1 : 0;
      tiles = now;
    }
    return changes;
  };
  for (int i = 0; i < kFrames; i += 10)
    drawUntilSettled(onTheWay(i));
  // What lies ahead of a moving eye is loaded in its first rounds still.
  int allocations = -1;
  int changes = 0;
  for (int i = 0; i < 8 && allocations != 0; ++i) {
    startCountingAllocations();
    changes = round();
    allocations = allocationsCounted();
  }
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(changes, 4) << "the eye hardly moves";
}

}  // namespace
}  // namespace tellurion::render
