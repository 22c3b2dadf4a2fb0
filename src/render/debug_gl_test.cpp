// The debug views: what they change in the picture, and that they change nothing else.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "geo/body.h"
#include "render/allocation_count_test.h"
#include "render/debug_legend.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace {

using raster::Rgba8;
using scene::DebugView;
using synthetic::viewAt;
using Picture = raster::Raster<Rgba8>;

constexpr scene::Viewport kSize{130, 120};  // no room for a legend
constexpr Rgba8 kGround{90, 90, 90, 255};
constexpr double kFill = 0.45;  // as debug_pass.cpp has it

double fromSrgb(std::uint8_t byte) {
  const double s = byte / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

int toSrgb(double linear) {
  return static_cast<int>(
      std::lround(255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055)));
}

int difference(Rgba8 a, Rgba8 b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

Rgba8 blended(Rgba8 over, double strength, Rgba8 under) {
  const auto mix = [&](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(toSrgb(strength * fromSrgb(a) + (1.0 - strength) * fromSrgb(b)));
  };
  return {mix(over.r, under.r), mix(over.g, under.g), mix(over.b, under.b), 255};
}

class DebugViewsTest : public synthetic::GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    renderer_.emplace(makeRenderer());
    const auto ready = renderer_->prepareDebugViews();
    ASSERT_TRUE(ready.has_value()) << io::describe(ready.error());
  }

  /// The whole Earth of one grey, unlit, from above a tile's middle: level 2 there, level 1 on the other roots.
  static scene::Frame earth(int level = 2, double height_m = 2e7) {
    scene::Frame frame;
    frame.view = viewAt(ellipsoid(), 11, 11, height_m, 0, -90, kSize);
    frame.light.enabled = false;
    frame.tiles = synthetic::wholeBody(tiling(), ellipsoid(), level, 8);
    const auto picture = synthetic::plainImage(kGround);
    for (scene::DrawnTile& tile : frame.tiles)
      synthetic::paint(frame, tile, picture);
    return frame;
  }
  static geo::Ellipsoid ellipsoid() { return geo::earth().ellipsoid; }
  static tiling::Tiling tiling() { return tiling::Tiling(tiling::Scheme::cube); }

  Picture drawn(scene::Frame& frame, std::initializer_list<DebugView> views) {
    frame.debug.views = {};
    for (const DebugView view : views)
      frame.debug.views.add(view);
    if (!target_ || target_->size().width != frame.view.viewport.width)
      target_.emplace(makeTarget(frame.view.viewport));
    statistics_ = renderer_->draw(frame, *target_);
    return readColour(*target_);
  }

  /// The pixel that shows a place of the body; nothing when it is out of the picture or beyond the limb.
  static std::optional<scene::PixelPosition> pixelOf(const scene::View& view, const geo::BodyPosition& p) {
    const geo::Vec3 outwards = geo::normalize(p.m);
    if (geo::dot(geo::normalize(view.eye - p), outwards) < 0.3) return std::nullopt;
    const geo::Vec3 at = view.viewFromBody * (p - view.eye);
    const double scale = 1.0 / (-at.z * view.pixelAngle());
    return scene::PixelPosition{at.x * scale + view.viewport.width / 2.0, -at.y * scale + view.viewport.height / 2.0};
  }

  static Rgba8 at(const Picture& picture, scene::PixelPosition pixel) {
    return picture.at(static_cast<int>(pixel.x), static_cast<int>(pixel.y));
  }

  /// Whether a pixel or one of its eight neighbours differs.
  static bool differsNear(const Picture& a, const Picture& b, scene::PixelPosition pixel) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int col = std::clamp(static_cast<int>(pixel.x) + dx, 0, a.width - 1);
        const int row = std::clamp(static_cast<int>(pixel.y) + dy, 0, a.height - 1);
        if (difference(a.at(col, row), b.at(col, row)) > 20) return true;
      }
    }
    return false;
  }

  std::optional<Renderer> renderer_;
  std::optional<RenderTarget> target_;
  RenderStatistics statistics_;
};

TEST_F(DebugViewsTest, NothingChangesUntilTheyAreAskedFor) {
  scene::Frame frame = earth();
  const Picture plain = drawn(frame, {});
  EXPECT_EQ(statistics_.drawCalls, 1);
  frame.debug.boxes.resize(frame.tiles.size());
  frame.debug.views.add(DebugView::levels);
  Renderer unprepared = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  EXPECT_EQ(unprepared.draw(frame, target).drawCalls, 1);
  EXPECT_EQ(readColour(target).samples, plain.samples);
}

TEST_F(DebugViewsTest, WireframeLiesAlongTheSidesAndNowhereElse) {
  scene::Frame frame = earth(0, 1e7);
  const Picture plain = drawn(frame, {});
  const Picture wires = drawn(frame, {DebugView::wireframe});
  EXPECT_EQ(statistics_.drawCalls, 2);
  int sides = 0;
  int middles = 0;
  int middlesHit = 0;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const scene::TerrainMesh& mesh = *tile.mesh;
    const auto place = [&](std::uint32_t i) {
      return mesh.origin + geo::Vec3(mesh.vertices[mesh.indices[i]].position_tile);
    };
    for (std::uint32_t i = mesh.interior.first; i < mesh.interior.count; i += 3) {
      for (std::uint32_t side = 0; side < 3; ++side) {
        const geo::BodyPosition from = place(i + side);
        const geo::BodyPosition to = place(i + (side + 1) % 3);
        const auto pixel = pixelOf(frame.view, from + (to - from) * 0.5);
        if (!pixel) continue;
        ++sides;
        EXPECT_TRUE(differsNear(wires, plain, *pixel));
      }
      const geo::BodyPosition centre{(place(i).m + place(i + 1).m + place(i + 2).m) / 3.0};
      if (const auto pixel = pixelOf(frame.view, centre)) {
        ++middles;
        middlesHit += difference(at(wires, *pixel), at(plain, *pixel)) > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(sides, 60);
  EXPECT_GT(middles, 20);
  EXPECT_EQ(middlesHit, 0);
}

TEST_F(DebugViewsTest, LevelsTintTilesInTheirColours) {
  scene::Frame frame = earth(2);
  const Picture plain = drawn(frame, {});
  const Picture tinted = drawn(frame, {DebugView::levels});
  EXPECT_EQ(statistics_.drawCalls, 2);
  int tiles = 0;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const auto pixel = pixelOf(frame.view, tile.mesh->origin);
    if (!pixel) continue;
    ++tiles;
    const Rgba8 colour = scene::levelColour(tile.id.level);
    EXPECT_LE(difference(at(tinted, *pixel), blended(colour, kFill, kGround)), 2);
    // The border's colour is the level's own.
    const auto corner = tiling().direction(tiling::rootPointIn(tile.id, 0.5, 0.0));
    const auto edge = pixelOf(frame.view, ellipsoid().bodyFromDirection(corner, 0.0));
    if (edge) {
      EXPECT_LE(difference(at(tinted, *edge), colour), 2);
    }
  }
  EXPECT_GT(tiles, 10);
  for (std::size_t i = 0; i < plain.samples.size(); ++i) {
    const bool sky = plain.samples[i] == Rgba8{0, 0, 0, 255};
    ASSERT_EQ(tinted.samples[i] == plain.samples[i], sky);
  }
}

TEST_F(DebugViewsTest, ErrorsAreHeat) {
  scene::Frame frame = earth(1);
  frame.debug.tolerance_px = 0.5;
  for (std::size_t i = 0; i < frame.tiles.size(); ++i)
    frame.tiles[i].error_px = 0.05 * static_cast<double>(i);
  const Picture heat = drawn(frame, {DebugView::error});
  const Picture both = drawn(frame, {DebugView::error, DebugView::levels});
  EXPECT_EQ(statistics_.drawCalls, 2);
  int tiles = 0;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const auto pixel = pixelOf(frame.view, tile.mesh->origin);
    if (!pixel) continue;
    ++tiles;
    const Rgba8 expected = blended(scene::errorColour(tile.error_px, 0.5), kFill, kGround);
    EXPECT_LE(difference(at(heat, *pixel), expected), 2) << tile.error_px;
    EXPECT_LE(difference(at(both, *pixel), expected), 2) << tile.error_px;
  }
  EXPECT_GT(tiles, 3);
}

TEST_F(DebugViewsTest, BoxesAreDrawnAlongTheirEdges) {
  scene::Frame frame = earth(1);
  const Picture plain = drawn(frame, {});
  const geo::BodyPosition middle = ellipsoid().bodyFromDirection(geo::directionFromDegrees(11, 11), 8e5);
  frame.debug.boxes.resize(frame.tiles.size());
  frame.debug.boxes[0] = {.centre = middle,
                          .halfAxes = {geo::Vec3(3e5, 0, 0), geo::Vec3(0, 6e5, 0), geo::Vec3(0, 0, 9e5)}};
  for (std::size_t i = 1; i < frame.tiles.size(); ++i)  // the others hide inside the body
    frame.debug.boxes[i] = {.centre = {}, .halfAxes = {geo::Vec3(1, 0, 0), geo::Vec3(0, 1, 0), geo::Vec3(0, 0, 1)}};
  const Picture boxes = drawn(frame, {DebugView::boxes});
  EXPECT_EQ(statistics_.drawCalls, 2);
  const scene::OrientedBox& box = frame.debug.boxes[0];
  for (unsigned corner = 0; corner < scene::OrientedBox::kCorners; ++corner) {
    for (const unsigned axis : {1u, 2u, 4u}) {
      const geo::Vec3 half = (box.corner(corner ^ axis) - box.corner(corner)) * 0.5;
      const auto pixel = pixelOf(frame.view, box.corner(corner) + half);
      ASSERT_TRUE(pixel.has_value());
      EXPECT_TRUE(differsNear(boxes, plain, *pixel)) << corner << " " << axis;
    }
  }
  const auto changed = std::ranges::count_if(boxes.samples, [&](const Rgba8& p) {
    return difference(p, plain.samples[static_cast<std::size_t>(&p - boxes.samples.data())]) > 0;
  });
  EXPECT_LT(changed, 400);  // lines, not faces
}

TEST_F(DebugViewsTest, AFrozenPyramidIsSeenFromOutside) {
  scene::Frame frame = earth(1);
  const Picture plain = drawn(frame, {});
  const scene::View frozen = viewAt(ellipsoid(), 11, 11, 3e6, 30, -80, kSize);
  frame.debug.frozenCut = frozen;
  frame.debug.frozenPyramid = scene::pyramidOf(frozen, ellipsoid());
  const Picture seen = drawn(frame, {});
  EXPECT_EQ(statistics_.drawCalls, 2);
  for (std::size_t i = 0; i < 4; ++i) {
    const scene::Segment& line = frame.debug.frozenPyramid[i];
    const auto pixel = pixelOf(frame.view, line.from + (line.to - line.from) * 0.5);
    ASSERT_TRUE(pixel.has_value());
    EXPECT_TRUE(differsNear(seen, plain, *pixel)) << i;
  }
}

TEST_F(DebugViewsTest, DepthAndTheNextPictureStayAsTheyAre) {
  scene::Frame frame = earth(2);
  const Picture plain = drawn(frame, {});
  const auto distance = readDistance(*target_, frame.view);
  frame.debug.boxes.assign(frame.tiles.size(),
                           {.centre = ellipsoid().bodyFromDirection(geo::directionFromDegrees(11, 11), 1e6),
                            .halfAxes = {geo::Vec3(1e5, 0, 0), geo::Vec3(0, 1e5, 0), geo::Vec3(0, 0, 1e5)}});
  EXPECT_NE(drawn(frame, {DebugView::wireframe, DebugView::levels, DebugView::error, DebugView::boxes}).samples,
            plain.samples);
  EXPECT_EQ(statistics_.drawCalls, 4);
  const auto after = readDistance(*target_, frame.view);
  for (std::size_t i = 0; i < distance.samples.size(); ++i) {
    ASSERT_TRUE(after.samples[i] == distance.samples[i] ||
                (std::isnan(after.samples[i]) && std::isnan(distance.samples[i])));
  }
  EXPECT_EQ(drawn(frame, {}).samples, plain.samples);
}

TEST_F(DebugViewsTest, ASteadyStateAllocatesNothing) {
  scene::Frame frame = earth(2);
  frame.view.viewport = {640, 480};
  frame.debug.boxes.resize(frame.tiles.size());
  drawn(frame, {DebugView::wireframe, DebugView::levels, DebugView::error, DebugView::boxes});
  for (int i = 0; i < 10; ++i) {  // the first round is for drivers, which compile what a view is the first to need
    frame.view = viewAt(ellipsoid(), 20 + i % 5, 30, 1e7, 0, -90, {640, 480});
    finish();
    startCountingAllocations();
    renderer_->draw(frame, *target_);
    const int allocated = allocationsCounted();
    if (i >= 5) {
      EXPECT_EQ(allocated, 0);
    }
  }
}

TEST_F(DebugViewsTest, TheLegendStandsInTheUpperLeftCorner) {
  scene::Frame frame = earth(2, 6e7);
  frame.view.viewport = {640, 480};
  const Picture picture = drawn(frame, {DebugView::levels});
  const Picture legend = legendPicture(legendRows(legendContentOf(frame)), 1);
  ASSERT_GT(legend.width, 40);
  for (int row = 0; row < legend.height; ++row) {
    for (int col = 0; col < legend.width; ++col)
      ASSERT_LE(difference(picture.at(8 + col, 8 + row), legend.at(col, row)), 1) << col << " " << row;
  }
  for (scene::DrawnTile& tile : frame.tiles)  // and is made anew for other levels
    tile.id = tile.id.parent();
  EXPECT_LE(difference(drawn(frame, {DebugView::levels}).at(8 + 8, 8 + 8), scene::levelColour(1)), 1);
}

TEST(DebugLegend, HasARowForEachLevelThatIsDrawn) {
  scene::Frame frame;
  for (const int level : {7, 3, 7})
    frame.tiles.push_back({.id = {.level = static_cast<std::uint8_t>(level)}});
  EXPECT_TRUE(legendRows(legendContentOf(frame)).empty());
  frame.debug.views.add(DebugView::levels);
  const auto rows = legendRows(legendContentOf(frame));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].label, "level 3");
  EXPECT_EQ(rows[0].colour, scene::levelColour(3));
  EXPECT_EQ(rows[1].label, "level 7");
}

TEST(DebugLegend, OfErrorsTellsTheTolerance) {
  scene::Frame frame;
  frame.debug.tolerance_px = 0.5;
  frame.debug.views.add(DebugView::error);
  const auto rows = legendRows(legendContentOf(frame));
  const auto tolerance = std::ranges::find(rows, std::string("0.5 px"), &LegendRow::label);
  ASSERT_NE(tolerance, rows.end());
  EXPECT_EQ(tolerance->colour, (Rgba8{0, 255, 0, 255}));
  ASSERT_NE(std::ranges::find(rows, std::string(">1 px"), &LegendRow::label), rows.end());
}

TEST(DebugLegend, EveryLetterOfItsLabelsIsInTheFont) {
  for (const char letter : std::string("0123456789.>-+levpx")) {
    const std::vector<LegendRow> blank{{{0, 0, 0, 255}, " "}};
    const std::vector<LegendRow> row{{{0, 0, 0, 255}, std::string(1, letter)}};
    EXPECT_NE(legendPicture(row, 1).samples, legendPicture(blank, 1).samples) << letter;
  }
  EXPECT_TRUE(legendPicture({}, 1).samples.empty());
  const std::vector<LegendRow> row{{{1, 2, 3, 255}, "level 1"}};
  EXPECT_EQ(legendPicture(row, 2).width, 2 * legendPicture(row, 1).width);
}

}  // namespace
}  // namespace tellurion::render
