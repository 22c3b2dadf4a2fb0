// Heights drawn 0 to 100 times as high, changed while the program runs: boxes and culling follow, and so does
// everything that asks for the ground.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <string>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/drawn_ground.h"
#include "scene/drawn_vertex.h"
#include "scene/globe.h"
#include "scene/navigation.h"
#include "scene/picking.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;

constexpr double kHills_m = 4000.0;  ///< hillsAt is between this and as much below
constexpr int kMaxTiles = 300;       ///< of a cut: more would tell nothing else
const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

class Exaggeration : public testing::TestWithParam<tiling::Scheme> {
 protected:
  void SetUp() override {
    const auto source = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 6);
    globe_ = Globe::fromLayers({.tiling = GetParam()}, {.elevation = {source}}).value();
    globe_->debugViews().add(DebugView::boxes);
  }

  double uniform(double low, double high) { return geo::uniform(random_, low, high); }

  /// 0 to 100, low numbers as often as high ones.
  double anyExaggeration() {
    const std::array some{0.0, 100.0, std::exp(uniform(std::log(0.1), std::log(100.0)))};
    return some[random_() % some.size()];
  }

  /// From well above any ground, drawn that high.
  View anyView(double exaggeration) {
    const double height_m = 1.05 * kHills_m * exaggeration + 2000.0 * std::exp(uniform(0.0, 8.0));
    return viewFrom(uniform(-90, 90), uniform(-180, 180), height_m, uniform(0, 360), uniform(-90, 5));
  }

  const Frame& framed(const View& view, const CutOptions& options = {.maxTiles = kMaxTiles}) {
    const auto end = std::chrono::steady_clock::now() + 240s;
    while (globe_->update(view, options).statistics.tilesWanted > 0 && std::chrono::steady_clock::now() < end)
      globe_->waitForArrivals(500ms);
    const Frame& frame = globe_->update(view, options);
    EXPECT_EQ(frame.statistics.tilesWanted, 0);
    return frame;
  }

  int coversOf(const Frame& frame, const geo::Direction& d) const {
    int covers = 0;
    for (const DrawnTile& tile : frame.tiles)
      covers += tiling_.tileAt(d, tile.id.level) == tile.id ? 1 : 0;
    return covers;
  }

  void expectBoxesHold(const Frame& frame) const;
  int expectNothingIsCulled(const Frame& frame);
  int expectToldAsDrawn(const Frame& frame);

  tiling::Tiling tiling_{GetParam()};
  std::mt19937_64 random_ = geo::seededGenerator();
  std::unique_ptr<Globe> globe_;
};

void Exaggeration::expectBoxesHold(const Frame& frame) const {
  ASSERT_EQ(frame.debug.boxes.size(), frame.tiles.size());
  for (std::size_t t = 0; t < frame.tiles.size(); ++t) {
    for (const TerrainVertex& vertex : frame.tiles[t].mesh->vertices) {
      const geo::BodyPosition drawn = drawnPosition(frame.tiles[t], vertex, frame);
      ASSERT_TRUE(frame.debug.boxes[t].contains(drawn, 1e-3)) << "level " << int{frame.tiles[t].id.level};
    }
  }
}

/// What is in the picture, and not hidden even by the deepest ground, is drawn, once.
int Exaggeration::expectNothingIsCulled(const Frame& frame) {
  int seen = 0;
  for (int k = 0; k < 5000; ++k) {
    const geo::Direction d = geo::directionFromLatLon(geo::Angle::radians(std::asin(uniform(-1, 1))),
                                                      geo::Angle::degrees(uniform(-180, 180)));
    const geo::BodyPosition p = kEarth.bodyFromDirection(d, frame.exaggeration * hillsAt(d));
    const auto pixel = pixelOf(frame.view, p);
    const Viewport& size = frame.view.viewport;
    if (!pixel || pixel->x < 0 || pixel->y < 0 || pixel->x > size.width || pixel->y > size.height) continue;
    const double distance_m = geo::length(p - frame.view.eye);
    const geo::Ray ray{frame.view.eye, (p - frame.view.eye) / distance_m};
    const auto hides = kEarth.intersect(ray, -kHills_m * frame.exaggeration);
    if (hides && *hides < distance_m) continue;
    ++seen;
    EXPECT_EQ(coversOf(frame, d), 1);
  }
  return seen;
}

/// The height that the globe tells of a place is that of its picture.
int Exaggeration::expectToldAsDrawn(const Frame& frame) {
  int compared = 0;
  for (int k = 0; k < 100; ++k) {
    const Viewport& size = frame.view.viewport;
    const geo::Ray ray = rayThrough(frame.view, {uniform(0, size.width), uniform(0, size.height)});
    const auto meets = kEarth.intersect(ray, 0.0);
    if (!meets) continue;
    const geo::Direction d = kEarth.directionFromBody(ray.origin + ray.direction * *meets);
    const auto told_m = globe_->groundHeight_m(d);
    const auto drawn = drawnPoint(frame, tiling_, d);
    if (!told_m || !drawn) continue;  // behind a mountain's foot
    ++compared;
    const double distance_m = geo::length(*drawn - frame.view.eye);
    // Both may be off from the finest ground; and what is lifted goes along normals of 16 bits.
    const double allowed_m = 2.0 * frame.statistics.maxScreenError_px * frame.view.pixelAngle() * distance_m +
                             kHills_m * std::abs(frame.exaggeration - 1.0) / 16384.0 + 1e-3;
    EXPECT_LE(geo::length(*drawn - kEarth.bodyFromDirection(d, *told_m)), allowed_m);
  }
  return compared;
}

TEST_P(Exaggeration, isFollowedByBoxesCullingAndHeights) {
  int seen = 0;
  int compared = 0;
  for (int i = 0; i < 8; ++i) {
    const double exaggeration = globe_->exaggeration() = anyExaggeration();
    SCOPED_TRACE(std::to_string(exaggeration) + " times, view " + std::to_string(i));
    const View view = anyView(exaggeration);
    const Frame& frame = framed(view);
    expectBoxesHold(frame);
    seen += expectNothingIsCulled(frame);
    compared += expectToldAsDrawn(frame);
    const geo::Direction below = kEarth.directionFromBody(view.eye);
    const double told_m = globe_->groundHeight_m(below).value();
    globe_->exaggeration() = 1.0;
    EXPECT_NEAR(told_m, exaggeration * globe_->groundHeight_m(below).value(), 1e-9 * std::abs(told_m));
    if (HasFailure()) return;
  }
  EXPECT_GT(seen, 100);
  EXPECT_GT(compared, 100);
}

TEST_P(Exaggeration, eyesAreKeptAboveTheGroundAsItIsDrawn) {
  const Ground ground{.ellipsoid = kEarth,
                      .height_m = [&](const geo::Direction& d) { return globe_->groundHeight_m(d); }};
  int raised = 0;
  const View over = anyView(1.0);
  framed(over);
  const double height_m = kEarth.geodeticFromBody(over.eye).height_m;
  for (int i = 0; i < 20; ++i) {
    View low = over;
    low.eye = low.eye + kEarth.directionFromBody(low.eye).n * (uniform(0.0, 5000.0) - height_m);
    globe_->exaggeration() = anyExaggeration();
    const View kept = cleared(low, ground);
    const geo::Geodetic eye = kEarth.geodeticFromBody(kept.eye);
    EXPECT_GE(eye.height_m, *globe_->groundHeight_m(kEarth.directionFromBody(kept.eye)) + kClearance_m - 1e-6);
    raised += geo::length(kept.eye - low.eye) > 1.0 ? 1 : 0;
  }
  EXPECT_GT(raised, 0);
}

TEST_P(Exaggeration, noneIsASmoothBody) {
  globe_->exaggeration() = 0.0;
  for (const bool morph : {false, true}) {
    const View view = anyView(0.0);
    const Frame& frame = framed(view, {.maxTiles = kMaxTiles, .morph = morph});
    for (const DrawnTile& tile : frame.tiles) {
      for (const TerrainVertex& vertex : tile.mesh->vertices) {
        const geo::BodyPosition drawn = drawnPosition(tile, vertex, frame);
        // A unit of the 16-bit normals over the highest hill; while it morphs, what its parent's chords are off.
        const double morphs_m = frame.statistics.maxScreenError_px * view.pixelAngle() * geo::length(drawn - view.eye);
        ASSERT_NEAR(kEarth.geodeticFromBody(drawn).height_m, 0.0, kHills_m / 32767.0 + (morph ? morphs_m : 0.0))
            << "level " << int{tile.id.level};
      }
    }
    EXPECT_EQ(globe_->groundHeight_m(kEarth.directionFromBody(view.eye)), 0.0);
  }
}

/// Ten times the heights with tiles for one: the ground is whole, coarser, and the statistics say so.
TEST_P(Exaggeration, aBudgetThatIsSpentShowsInTheStatistics) {
  const View view = viewFrom(10.0, 20.0, 300e3, 30.0, -40.0);
  const FrameStatistics once = framed(view).statistics;
  EXPECT_FALSE(once.cappedByBudget);
  EXPECT_LE(once.maxScreenError_px, 1.0);
  const int budget = once.tilesVisited;
  globe_->exaggeration() = 10.0;
  const Frame& frame = framed(view, {.maxTiles = budget});
  EXPECT_TRUE(frame.statistics.cappedByBudget);
  EXPECT_FALSE(frame.complete);
  EXPECT_GT(frame.statistics.maxScreenError_px, 1.0);
  for (int row = 0; row <= 40; ++row) {
    for (int col = 0; col <= 40; ++col) {
      const geo::Ray ray = rayThrough(view, {col / 40.0 * view.viewport.width, row / 40.0 * view.viewport.height});
      const auto meets = kEarth.intersect(ray, 0.0);
      if (!meets) continue;
      EXPECT_EQ(coversOf(frame, kEarth.directionFromBody(ray.origin + ray.direction * *meets)), 1);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Exaggeration,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::scene
