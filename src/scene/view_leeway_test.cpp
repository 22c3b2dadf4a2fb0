// The views that a cut is kept for: what it promises holds for each of them.

#include "scene/view_leeway.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "scene/fake_tree_test.h"
#include "scene/late_globe_test.h"

namespace tellurion::scene {
namespace {

geo::Vec3 randomUnit(std::mt19937_64& random) {
  geo::Vec3 v{0.0};
  do {
    v = {geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1)};
  } while (geo::dot(v, v) > 1.0 || geo::dot(v, v) < 1e-4);
  return geo::normalize(v);
}

/// Turned about an axis, and with its eye moved.
View moved(View view, const geo::Vec3& by_m, const geo::Vec3& axis, double turn_rad) {
  view.eye = view.eye + by_m;
  geo::Mat3 turn(1.0);
  for (int i = 0; i < 3; ++i) {
    const geo::Vec3 v = turn[i];
    turn[i] = v * std::cos(turn_rad) + geo::cross(axis, v) * std::sin(turn_rad) +
              axis * (geo::dot(axis, v) * (1.0 - std::cos(turn_rad)));
  }
  view.viewFromBody = view.viewFromBody * turn;
  return view;
}

/// One of those that the leeway is for, mostly at its end.
View viewWithin(const View& middle, const Leeway& leeway, std::mt19937_64& random) {
  const double move_m = leeway.move_m * std::cbrt(geo::uniform(random, 0.3, 0.999));
  const geo::Vec3 by_m = randomUnit(random) * move_m;
  const geo::Vec3 axis = randomUnit(random);
  for (double turn_rad = 2.0 * leeway.turn; turn_rad > 1e-9; turn_rad *= 0.8) {
    const View view = moved(middle, by_m, axis, turn_rad);
    if (isWithin(view, middle, leeway)) return view;
  }
  return moved(middle, by_m, axis, 0.0);
}

bool isInPicture(const View& view, const geo::BodyPosition& p) {
  if (view.isAllAround) return true;
  const geo::Vec3 v = view.viewFromBody * (p - view.eye);
  const Sides sides = view.sides();
  const double x = v.x / -v.z, y = v.y / -v.z;
  return v.z < 0.0 && x >= sides.left && x <= sides.right && y >= sides.bottom && y <= sides.top;
}

/// No ground of the body lies deeper than depth_m, so what is seen through that is seen.
bool isSeen(const View& view, const geo::BodyPosition& p, double depth_m) {
  if (!isInPicture(view, p)) return false;
  const auto hit = kEarth.intersect({view.eye, p - view.eye}, -depth_m);
  return !hit || *hit >= 1.0;
}

class LeewayOn : public testing::TestWithParam<Scheme> {};

INSTANTIATE_TEST_SUITE_P(All, LeewayOn, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

// Nothing that one of the views sees is missing, and what is drawn is off by no more than is told and allowed.
TEST_P(LeewayOn, theCutIsRightForAllOfItsViews) {
  constexpr double kDepth_m = 500.0;
  std::mt19937_64 random = geo::seededGenerator();
  const Tiling tiling(GetParam());
  long seen = 0;
  long drawnMore = 0;
  for (int i = 0; i < 40; ++i) {
    FakeTree tree(tiling);
    View middle = randomView(random);
    if (i % 3 == 1) middle.offAxis = Sides{.left = -0.2, .right = 1.1, .bottom = -0.9, .top = 0.1};
    if (i % 8 == 5) middle.isAllAround = true;
    const double height_m = kEarth.geodeticFromBody(middle.eye).height_m;
    std::array<CutMemory, 2> memories;
    CutHistory history{.last = &memories[0], .now = &memories[1]};
    history.leeway = {.move_m = (height_m - 9000.0) * geo::uniform(random, 0.0, 0.2),
                      .turn = geo::uniform(random, 0.0, 0.1)};
    // Exaggeration only changes boxes and errors, as rough ground does.
    const double roughness = std::exp(geo::uniform(random, -1.0, 1.0));
    tree.roughness = [=](const TileId&) { return roughness; };
    const CutOptions options{.tolerance_px = std::exp(geo::uniform(random, 0.0, 2.0)), .maxTiles = 1000000};
    const Selection cut = select(tiling, kEarth, middle, options, kDepth_m, tree, &history);
    ASSERT_TRUE(cut.wanted.empty());
    ASSERT_FALSE(cut.cappedByBudget);
    std::map<TileId, const SelectedTile*> drawn;
    for (const SelectedTile& tile : cut.drawn)
      drawn.emplace(tile.id, &tile);
    for (int k = 0; k < 10; ++k) {
      const View view = viewWithin(middle, history.leeway, random);
      ASSERT_TRUE(isWithin(view, middle, history.leeway));
      for (const SelectedTile& tile : cut.drawn) {
        const double error_px =
            pixelsAcross(tile.facts->error_m, tile.facts->tightBox.distance_m(view.eye), view.pixelAngle());
        ASSERT_LE(error_px, tile.error_px * (1.0 + 1e-9) + 1e-12);
        if (tile.id.level < tree.deepest) {
          ASSERT_LE(error_px, options.tolerance_px * (1.0 + 1e-9));
        }
      }
      for (int n = 0; n < 300; ++n) {
        // Near the eye as well as at the horizon.
        const geo::Direction d{geo::normalize(kEarth.directionFromBody(view.eye).n +
                                              randomUnit(random) * std::exp(geo::uniform(random, -7.0, 0.5)))};
        const geo::BodyPosition p = kEarth.bodyFromDirection(d, geo::uniform(random, -kDepth_m, 9000.0));
        if (!isSeen(view, p, kDepth_m)) continue;
        ++seen;
        drawnMore += isSeen(middle, p, kDepth_m) ? 0 : 1;
        const TileId deepest = tiling.tileAt(d, tree.deepest);
        int covers = 0;
        for (int level = 0; level <= tree.deepest; ++level)
          covers += drawn.count(deepest.ancestor(level)) != 0 ? 1 : 0;
        ASSERT_EQ(covers, 1);
      }
    }
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(drawnMore, 10) << "of what only views aside see";
}

TEST(ViewLeeway, knowsItsViews) {
  const View middle = viewOver(46.0, 8.0, 20e3, 30.0, -30.0);
  const geo::Vec3 up = kEarth.directionFromBody(middle.eye).n;
  const Leeway leeway{.move_m = 100.0, .turn = 0.01};
  EXPECT_TRUE(isWithin(middle, middle, {}));
  EXPECT_TRUE(isWithin(moved(middle, up * 99.0, up, 0.001), middle, leeway));
  EXPECT_FALSE(isWithin(moved(middle, up * 101.0, up, 0.0), middle, leeway));
  EXPECT_FALSE(isWithin(moved(middle, up * 0.0, up, 0.05), middle, leeway));
  EXPECT_FALSE(isWithin(moved(middle, up * 0.0, up, 3.0), middle, leeway));
  View other = middle;
  other.verticalFov = geo::Angle::degrees(49.0);
  EXPECT_FALSE(isWithin(other, middle, leeway));
  other = middle;
  other.offAxis = Sides{.left = -0.5, .right = 0.9, .bottom = -0.3, .top = 0.3};
  EXPECT_FALSE(isWithin(other, middle, leeway));
  const View aside = other;
  EXPECT_TRUE(isWithin(moved(aside, up * 99.0, up, 0.001), aside, leeway));
  EXPECT_FALSE(isWithin(moved(aside, up * 0.0, up, 0.05), aside, leeway));
  other = middle;
  other.agreedPixelAngle = 1e-4;
  EXPECT_FALSE(isWithin(other, middle, leeway));
  View around = middle;
  around.isAllAround = true;
  EXPECT_FALSE(isWithin(around, middle, leeway));
  EXPECT_TRUE(isWithin(moved(around, up * 99.0, up, 3.0), around, leeway));
}

TEST(ViewLeeway, lastsForSomeFramesOfAnEyeThatGoesOn) {
  const View first = viewOver(46.0, 8.0, 20e3, 30.0, -30.0);
  const geo::Vec3 up = kEarth.directionFromBody(first.eye).n;
  const auto after = [&](double frames) {
    return moved(first, geo::Vec3(0.6, 0.0, 0.8) * (frames * 10.0), up, frames * 1e-4);
  };
  const Leeway leeway = leewayFor(first, after(1), 10e3);
  EXPECT_TRUE(isWithin(after(4), after(1), leeway));
  EXPECT_FALSE(isWithin(after(30), after(1), leeway));
  // None at rest, for another field of view, and none that the ground is too near for.
  EXPECT_EQ(leewayFor(first, first, 10e3).move_m, 0.0);
  EXPECT_EQ(leewayFor(first, first, 10e3).turn, 0.0);
  EXPECT_EQ(leewayFor(first, after(1), 0.0).move_m, 0.0);
  EXPECT_EQ(leewayFor(first, after(1), -5.0).move_m, 0.0);
  EXPECT_EQ(leewayFor(first, after(1000), 1e4).move_m, 0.0);
  EXPECT_LE(leewayFor(first, after(20), 1e4).move_m, 0.025 * 1e4);
  for (const double degrees : {0.01, 0.1, 1.0, 10.0}) {
    const View turned = viewFrom(46.0, 8.0, 40e3, 20.0 + degrees, -60.0, kViewport);
    EXPECT_LE(leewayFor(viewFrom(46.0, 8.0, 40e3, 20.0, -60.0, kViewport), turned, 1e4).turn, 0.005) << degrees;
  }
}

}  // namespace
}  // namespace tellurion::scene
