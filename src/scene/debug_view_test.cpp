#include "scene/debug_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/globe.h"
#include "scene/picking.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;

int difference(raster::Rgba8 a, raster::Rgba8 b) {
  return std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b);
}

TEST(DebugViews, AreParsedByTheirNames) {
  for (const DebugView view : kDebugViews) {
    const auto parsed = parseDebugViews(nameOf(view));
    ASSERT_TRUE(parsed.has_value());
    for (const DebugView other : kDebugViews)
      EXPECT_EQ(parsed->has(other), other == view);
  }
  const auto several = parseDebugViews("levels,wireframe,levels");
  ASSERT_TRUE(several.has_value());
  EXPECT_TRUE(several->has(DebugView::levels) && several->has(DebugView::wireframe));
  EXPECT_FALSE(several->has(DebugView::error) || several->has(DebugView::boxes));
}

TEST(DebugViews, WrongNamesAreToldWithTheRightOnes) {
  for (const char* wrong : {"", ",", "level", "levels,", "levels,,boxes", "levels, boxes", "LEVELS"}) {
    const auto parsed = parseDebugViews(wrong);
    ASSERT_FALSE(parsed.has_value()) << wrong;
    for (const DebugView view : kDebugViews)
      EXPECT_NE(io::describe(parsed.error()).find(nameOf(view)), std::string::npos) << wrong;
  }
}

TEST(DebugViews, LevelsHaveColoursThatDiffer) {
  for (int a = 0; a <= tiling::kMaxLevel; ++a) {
    for (int b = a + 1; b <= std::min(a + 12, tiling::kMaxLevel); ++b)
      EXPECT_GT(difference(levelColour(a), levelColour(b)), 60) << a << " and " << b;
    EXPECT_GT(difference(levelColour(a), levelColour(a + 1)), 200) << a;
  }
}

TEST(DebugViews, HeatGoesFromBlueOverGreenToRed) {
  EXPECT_EQ(errorColour(0.0, 0.5), (raster::Rgba8{0, 0, 255, 255}));
  EXPECT_EQ(errorColour(0.5, 0.5), (raster::Rgba8{0, 255, 0, 255}));
  EXPECT_EQ(errorColour(1.0, 0.5), (raster::Rgba8{255, 0, 0, 255}));
  EXPECT_EQ(errorColour(1e9, 0.5), (raster::Rgba8{255, 0, 0, 255}));
  EXPECT_EQ(errorColour(0.500001, 0.5).r, 255);
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(errorColour(0.01 * i, 1.0).r, 0);
}

constexpr Viewport kViewport{.width = 640, .height = 480};

/// Whether a point lies on the sight of a view's corner: -1 or 1 in x and y, whichever.
bool isAtACorner(const View& view, const geo::BodyPosition& p) {
  const geo::Vec3 at = view.viewFromBody * (p - view.eye);
  const double y = at.y / -at.z / std::tan(view.verticalFov.radians() / 2);
  const double x = at.x / -at.z / std::tan(view.verticalFov.radians() / 2) * 480 / 640;
  return at.z < 0.0 && std::abs(std::abs(x) - 1.0) < 1e-6 && std::abs(std::abs(y) - 1.0) < 1e-6;
}

TEST(DebugViews, APyramidHasItsEyeAndFourCorners) {
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  for (const View& view : {viewFrom(20, 30, 1e5, 40, -90, kViewport), viewFrom(-89.9, 30, 2e3, 40, 0, kViewport),
                           viewFrom(0, 180, 4e7, 0, -70, kViewport), viewFrom(0, 0, 2.0, 0, 90, kViewport),
                           viewFrom(10, 10, -6.3e6, 0, -10, kViewport)}) {
    const auto lines = pyramidOf(view, earth);
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(lines[i].from, view.eye);
      EXPECT_TRUE(isAtACorner(view, lines[i].to));
      EXPECT_EQ(lines[4 + i].from, lines[i].to);
      EXPECT_EQ(lines[4 + i].to, lines[(i + 1) % 4].to);
      EXPECT_GT(geo::length(lines[i].to - lines[(i + 1) % 4].to), 0.0);
    }
  }
  for (const Segment& line : pyramidOf(viewFrom(20, 30, 1e5, 40, -90, kViewport), earth))
    EXPECT_NEAR(earth.geodeticFromBody(line.to).height_m, 0.0, 1e-3);
}

class DebugGlobe : public ::testing::Test {
 protected:
  DebugGlobe() {
    Scene scene;
    GlobeLayers layers{
        .elevation = {std::make_shared<ProceduralSource>(raster::Kind::elevation, scene.tiling, 6)},
        .imagery = {{.source = std::make_shared<ProceduralSource>(raster::Kind::imagery, scene.tiling, 6)}}};
    globe_ = Globe::fromLayers(scene, std::move(layers)).value();
  }

  const Frame& loaded(const View& view) {
    const auto end = std::chrono::steady_clock::now() + 240s;
    while (std::chrono::steady_clock::now() < end) {
      const Frame& frame = globe_->update(view);
      if (frame.complete) return frame;
      globe_->waitForArrivals(1000ms);
    }
    ADD_FAILURE() << "never complete";
    return globe_->update(view);
  }

  static std::vector<tiling::TileId> tilesOf(const Frame& frame) {
    std::vector<tiling::TileId> ids;
    for (const DrawnTile& tile : frame.tiles)
      ids.push_back(tile.id);
    return ids;
  }

  std::unique_ptr<Globe> globe_;
};

TEST_F(DebugGlobe, TilesTellTheirScreenErrors) {
  const Frame& frame = loaded(viewFrom(20, 30, 3e5, 40, -40, kViewport));
  double most_px = 0.0;
  for (const DrawnTile& tile : frame.tiles) {
    EXPECT_GE(tile.error_px, 0.0);
    most_px = std::max(most_px, tile.error_px);
  }
  EXPECT_GT(most_px, 0.0);
  EXPECT_EQ(most_px, frame.statistics.maxScreenError_px);
}

TEST_F(DebugGlobe, BoxesComeWhenAskedForAndHoldTheirGround) {
  const View view = viewFrom(20, 30, 3e5, 40, -40, kViewport);
  EXPECT_TRUE(loaded(view).debug.boxes.empty());
  globe_->debugViews().add(DebugView::boxes);
  const Frame& frame = loaded(view);
  ASSERT_EQ(frame.debug.boxes.size(), frame.tiles.size());
  for (std::size_t i = 0; i < frame.tiles.size(); ++i) {
    const TerrainMesh& mesh = *frame.tiles[i].mesh;
    for (const TerrainVertex& vertex : mesh.vertices)
      ASSERT_TRUE(frame.debug.boxes[i].contains(mesh.origin + geo::Vec3(vertex.position_tile), 1e-3));
  }
  globe_->debugViews().toggle(DebugView::boxes);
  EXPECT_TRUE(loaded(view).debug.boxes.empty());
}

TEST_F(DebugGlobe, AFrozenCutStaysWhileTheEyeMovesOn) {
  const View first = viewFrom(20, 30, 3e5, 40, -40, kViewport);
  const View second = viewFrom(21, 33, 9e5, 300, -80, kViewport);
  const auto tiles = tilesOf(loaded(first));
  const auto followed = tilesOf(loaded(second));
  EXPECT_NE(followed, tiles);

  loaded(first);
  globe_->freezeCut(first);
  EXPECT_TRUE(globe_->cutIsFrozen());
  const Frame& frozen = loaded(second);
  EXPECT_EQ(tilesOf(frozen), tiles);
  EXPECT_EQ(frozen.view.eye, second.eye);
  EXPECT_EQ(frozen.debug.frozenCut->eye, first.eye);
  EXPECT_EQ(frozen.debug.frozenPyramid[0].from, first.eye);

  globe_->freezeCut(std::nullopt);
  EXPECT_FALSE(globe_->cutIsFrozen());
  EXPECT_EQ(tilesOf(loaded(second)), followed);
}

// As `render --freeze-at` does: nothing was loaded before.
TEST_F(DebugGlobe, ACutFrozenBeforeAnythingIsThereIsLoaded) {
  const View first = viewFrom(20, 30, 3e5, 40, -40, kViewport);
  globe_->freezeCut(first);
  const auto tiles = tilesOf(loaded(viewFrom(-20, -150, 1e7, 0, -90, kViewport)));
  EXPECT_GT(tiles.size(), 20u);
  globe_->freezeCut(std::nullopt);
  EXPECT_EQ(tilesOf(loaded(first)), tiles);
}

}  // namespace
}  // namespace tellurion::scene
