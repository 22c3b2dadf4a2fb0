#include "scene/select.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/fake_tree_test.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

using IdSet = std::set<TileId>;
/// What is drawn, and what would be in the margin around the picture: together they are the cut's leaves.
std::vector<SelectedTile> leavesOf(const Selection& s) {
  std::vector<SelectedTile> out = s.drawn;
  out.insert(out.end(), s.soon.begin(), s.soon.end());
  return out;
}

IdSet idsOf(const std::vector<SelectedTile>& tiles) {
  IdSet out;
  for (const SelectedTile& t : tiles)
    out.insert(t.id);
  return out;
}

class SelectOn : public testing::TestWithParam<Scheme> {
 protected:
  Selection selected(const View& view, TileTree& tree, CutOptions options = {}) {
    return select(tiling, kEarth, view, options, 500.0, tree);
  }

  void expectBalancedAndDisjoint(const Selection& s) {
    const std::vector<SelectedTile> leaves = leavesOf(s);
    const IdSet ids = idsOf(leaves);
    ASSERT_EQ(ids.size(), leaves.size());
    for (const SelectedTile& t : leaves) {
      for (int level = 0; level < t.id.level; ++level)
        ASSERT_EQ(ids.count(t.id.ancestor(level)), 0u);
      for (std::size_t e = 0; e < 4; ++e) {
        const TileId same = tiling.edgeNeighbour(t.id, tiling::kEdges[e]).tile;
        for (int level = 0; level + 1 < same.level; ++level)
          ASSERT_EQ(ids.count(same.ancestor(level)), 0u) << "two levels apart";
        const bool coarser = same.level > 0 && ids.count(same.parent()) != 0;
        ASSERT_EQ(((t.coarseEdges >> e) & 1) != 0, coarser);
      }
    }
  }

  Tiling tiling{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(All, SelectOn, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(SelectOn, errorsAreWithinToleranceAndNeighboursBalanced) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  tree.roughness = [](const TileId& id) { return 0.05 + ((id.x * 7 + id.y * 13 + id.root) % 11) * 0.3; };
  for (int i = 0; i < 40; ++i) {
    const Selection s = selected(randomView(random), tree, {.tolerance_px = 1.5, .maxTiles = 100000});
    EXPECT_TRUE(s.wanted.empty());
    EXPECT_FALSE(s.cappedByBudget);
    EXPECT_LE(s.maxScreenError_px, 1.5);
    expectBalancedAndDisjoint(s);
  }
}

TEST_P(SelectOn, aTighterToleranceOnlyRefines) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  for (int i = 0; i < 20; ++i) {
    const View view = randomView(random);
    const IdSet coarse = idsOf(selected(view, tree, {.tolerance_px = 4.0, .maxTiles = 100000}).drawn);
    const IdSet fine = idsOf(selected(view, tree, {.tolerance_px = 1.0, .maxTiles = 100000}).drawn);
    for (const TileId& id : fine) {
      for (int level = id.level + 1; level <= 16; ++level) {
        for (const TileId& c : coarse)
          ASSERT_FALSE(c.level == level && c.isDescendantOf(id) && !(c == id));
      }
    }
  }
}

TEST_P(SelectOn, samplesAreAsDenseAsAsked) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  tree.roughness = [](const TileId&) { return 0.0; };
  for (int i = 0; i < 10; ++i) {
    const View view = randomView(random);
    int before = 0;
    for (const double spacing_px : {14.0, 10.0, 2.2, 1.0}) {
      constexpr double kAnyError = std::numeric_limits<double>::infinity();
      const CutOptions options{.tolerance_px = kAnyError, .maxSpacing_px = spacing_px, .maxTiles = 1000000};
      const Selection s = selected(view, tree, options);
      for (const SelectedTile& t : s.drawn) {
        const TileFacts& facts = *tree.facts(t.id);
        ASSERT_LE(pixelsAcross(facts.spacing_m, facts.tightBox.distance_m(view.eye), view.pixelAngle()), spacing_px);
      }
      expectBalancedAndDisjoint(s);
      EXPECT_GE(s.visited, before);  // of the drawn there may be fewer: small tiles are culled better
      before = s.visited;
    }
  }
}

TEST_P(SelectOn, texelsAreAsFineAsAsked) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  tree.roughness = [](const TileId&) { return 0.0; };
  tree.texelsAcross = 256.0;
  for (int i = 0; i < 10; ++i) {
    const View view = randomView(random);
    int before = 0;
    for (const double texel_px : {10.0, 3.0, 1.0}) {
      const Selection s = selected(view, tree, {.texelTolerance_px = texel_px, .maxTiles = 100000});
      for (const SelectedTile& t : s.drawn) {
        const TileFacts& facts = *tree.facts(t.id);
        ASSERT_LE(pixelsAcross(facts.texel_m, facts.tightBox.distance_m(view.eye), view.pixelAngle()), texel_px);
      }
      EXPECT_GE(s.visited, before);
      before = s.visited;
    }
  }
  const View near = viewOver(47, 11, 20000, 0, -30);
  EXPECT_LT(2 * selected(near, tree, {.texelTolerance_px = 4.0}).visited, selected(near, tree).visited);
}

TEST_P(SelectOn, levelsDoNotDependOnWhereTheEyeLooks) {
  FakeTree tree(tiling);
  const auto levelAt = [&](double heading, const geo::Direction& d) {
    for (const SelectedTile& t : selected(viewOver(47, 11, 20000, heading, -30), tree).drawn) {
      if (tiling.tileAt(d, t.id.level) == t.id) return static_cast<int>(t.id.level);
    }
    return -1;
  };
  // A place ahead of both of two views that look 20 degrees apart.
  const geo::Direction d = geo::directionFromDegrees(47.25, 11);
  EXPECT_GE(levelAt(0, d), 0);
  EXPECT_EQ(levelAt(-10, d), levelAt(10, d));
}

TEST_P(SelectOn, whatIsNotLoadedIsWantedAndCoveredFromAbove) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 20; ++i) {
    FakeTree tree(tiling);
    const unsigned salt = static_cast<unsigned>(geo::uniform(random, 0, 1000));
    tree.loaded = [=](const TileId& id) {
      return id.level == 0 || (id.x * 31 + id.y * 17 + id.root * 5 + id.level + salt) % 7 != 0;
    };
    const Selection s = selected(randomView(random), tree, {.tolerance_px = 1.0, .maxTiles = 100000});
    expectBalancedAndDisjoint(s);
    for (const SelectedTile& t : s.drawn)
      ASSERT_TRUE(tree.loaded(t.id));
    for (const WantedTile& w : s.wanted) {
      ASSERT_FALSE(tree.loaded(w.id));
      ASSERT_GT(w.priority, 0.0);
    }
    ASSERT_TRUE(std::is_sorted(s.wanted.begin(), s.wanted.end(),
                               [](const auto& a, const auto& b) { return a.priority > b.priority; }));
  }
}

TEST_P(SelectOn, theBudgetIsKept) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  for (int i = 0; i < 20; ++i) {
    const Selection s = selected(randomView(random), tree, {.tolerance_px = 0.2, .maxTiles = 60});
    EXPECT_LE(static_cast<int>(s.drawn.size()), 60 + tiling.rootCount());
    expectBalancedAndDisjoint(s);
  }
}

TEST_P(SelectOn, trianglesAndBytesHaveTheirBudgets) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  const auto costOf = [&](const Selection& s) {
    std::int64_t triangles = 0;
    for (const SelectedTile& t : s.drawn)
      triangles += t.facts->triangles;
    return triangles;
  };
  for (int i = 0; i < 20; ++i) {
    const View view = randomView(random);
    const CutOptions all{.tolerance_px = 1.0, .maxTiles = 100000};
    const std::int64_t whole = costOf(selected(view, tree, all));
    CutOptions options = all;
    options.maxTriangles = std::max<std::int64_t>(whole / 2, 12 * FakeTree::kTriangles);
    const Selection s = selected(view, tree, options);
    EXPECT_LE(costOf(s), options.maxTriangles);
    EXPECT_EQ(s.cappedByBudget, s.maxScreenError_px > all.tolerance_px);
    expectBalancedAndDisjoint(s);
    CutOptions bytes = all;
    bytes.maxBytes = static_cast<std::uint64_t>(options.maxTriangles) * FakeTree::kBytesATriangle;
    EXPECT_EQ(idsOf(selected(view, tree, bytes).drawn), idsOf(s.drawn)) << "each triangle has as many bytes";
  }
}

TEST_P(SelectOn, aBudgetIsSpentOnlyWhereTheGroundIsTooCoarseForIt) {
  std::mt19937_64 random = geo::seededGenerator();
  FakeTree tree(tiling);
  int toldOf = 0, notToldOf = 0;
  for (int i = 0; i < 6; ++i) {
    const View view = randomView(random);
    CutOptions options{.tolerance_px = 1.0, .maxTiles = 100000, .morph = false};
    const auto least = static_cast<int>(leavesOf(selected(view, tree, options)).size());
    options.morph = true;
    const auto most = static_cast<int>(leavesOf(selected(view, tree, options)).size());
    for (options.maxTiles = least / 2; options.maxTiles < most + 10;
         options.maxTiles += std::max(1, (most - least / 2) / 12)) {
      const Selection s = selected(view, tree, options);
      if (!s.cappedByBudget) {
        ASSERT_LE(s.maxScreenError_px, options.tolerance_px) << options.maxTiles << " of " << most;
      }
      if (options.maxTiles < most) ++(s.cappedByBudget ? toldOf : notToldOf);
    }
  }
  EXPECT_GT(toldOf, 0);
  EXPECT_GT(notToldOf, 0) << "what is only made ready was to be left out";
}

TEST_P(SelectOn, missingRootsAreWantedFirst) {
  FakeTree tree(tiling);
  tree.loaded = [](const TileId&) { return false; };
  const Selection s = selected(viewOver(0, 0, 15e6, 0, -90), tree);
  EXPECT_TRUE(s.drawn.empty());
  ASSERT_FALSE(s.wanted.empty());
  for (const WantedTile& w : s.wanted)
    EXPECT_EQ(w.id.level, 0);
  EXPECT_EQ(static_cast<int>(s.wanted.size()), tiling.rootCount());
}

TEST_P(SelectOn, nothingThatFallsIntoThePictureIsCulled) {
  std::mt19937_64 random = geo::seededGenerator();
  const HeightRange range{.low_m = -8000.0, .high_m = 9000.0};
  int seen = 0;
  for (int i = 0; i < 3000; ++i) {
    const View view = randomView(random);
    const int level = static_cast<int>(geo::uniform(random, 0, 12.99));
    // A random place near the eye's horizon or under it, and the tile around it.
    const geo::Direction under = kEarth.directionFromBody(view.eye);
    const double reach = std::exp(geo::uniform(random, -7, 0.5));
    const geo::Direction d{geo::normalize(
        under.n +
        geo::Vec3(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1)) * reach)};
    const OrientedBox box = estimatedBox(tiling, kEarth, tiling.tileAt(d, level), range);
    const geo::BodyPosition p = kEarth.bodyFromDirection(d, geo::uniform(random, range.low_m, range.high_m));
    ASSERT_TRUE(box.contains(p, 1e-6)) << "level " << level;
    const geo::Vec3 inView = view.viewFromBody * (p - view.eye);
    const double y = std::tan(view.verticalFov.radians() / 2.0);
    const bool inPicture =
        inView.z < 0 && std::abs(inView.y) <= -inView.z * y && std::abs(inView.x) <= -inView.z * y * 10.0 / 7.0;
    if (inPicture) {
      ASSERT_TRUE(ViewFrustum(view).mayShow(box));
    }
    // Hidden means: the straight way from the eye enters the lowest ground there is.
    const geo::Ellipsoid lowest(kEarth.semiMajorAxis_m() - 8000.0,
                                1.0 - (kEarth.semiMinorAxis_m() - 8000.0) / (kEarth.semiMajorAxis_m() - 8000.0));
    const auto hit = lowest.intersect({view.eye, p - view.eye});
    const bool visible = !hit || *hit >= 1.0;
    if (visible) {
      ASSERT_FALSE(isBeyondHorizon(box, kEarth.horizon(view.eye, 8000.0)));
    }
    seen += inPicture && visible ? 1 : 0;
  }
  EXPECT_GT(seen, 50);
}

TEST(Select, cullingIsWorthIt) {
  const Tiling tiling(Scheme::cube);
  FakeTree tree(tiling);
  const Selection s = select(tiling, kEarth, viewOver(10, 10, 15000, 0, -20), {.tolerance_px = 1.0}, 500.0, tree);
  EXPECT_GT(s.culledFrustum, 10);
  EXPECT_GT(s.culledHorizon, 0);
}

TEST(ViewFrustum, behindAndBeside) {
  const View view = viewOver(0, 0, 100.0, 0, 0);  // looks north; east is +y, up +x
  const auto boxAt = [&](double up, double east, double north) {
    OrientedBox box{.centre = view.eye + geo::Vec3(up, east, north)};
    box.halfAxes = {geo::Vec3(1, 0, 0), geo::Vec3(0, 1, 0), geo::Vec3(0, 0, 1)};
    return box;
  };
  const ViewFrustum frustum(view);
  EXPECT_TRUE(frustum.mayShow(boxAt(0, 0, 100)));
  EXPECT_FALSE(frustum.mayShow(boxAt(0, 0, -100)));
  EXPECT_FALSE(frustum.mayShow(boxAt(0, 200, 100)));
  EXPECT_FALSE(frustum.mayShow(boxAt(200, 0, 100)));
  EXPECT_TRUE(frustum.mayShow(boxAt(0, 0, 0)));
}

TEST(OrientedBox, distances) {
  OrientedBox box{.centre = {{10.0, 0.0, 0.0}}};
  box.halfAxes = {geo::Vec3(2, 0, 0), geo::Vec3(0, 3, 0), geo::Vec3(0, 0, 4)};
  EXPECT_DOUBLE_EQ(box.distance_m({{10.0, 0.0, 0.0}}), 0.0);
  EXPECT_DOUBLE_EQ(box.distance_m({{0.0, 0.0, 0.0}}), 8.0);
  EXPECT_DOUBLE_EQ(box.distance_m({{10.0, 6.0, 8.0}}), 5.0);
  EXPECT_TRUE(box.contains({{11.9, -2.9, 3.9}}));
  EXPECT_FALSE(box.contains({{12.1, 0.0, 0.0}}));
}

/// Children of all roots are worth their copies, but one frame may copy those of one root only.
TEST(Select, theWorstIsCopiedFirst) {
  const Tiling tiling(Scheme::cube);
  const View view = viewOver(30, 45, 20e6, 0, -90);
  for (std::uint8_t worst = 0; worst < 6; ++worst) {
    FakeTree tree(tiling);
    tree.deepest = 1;
    tree.roughness = [&](const TileId& id) { return id.root == worst ? 200.0 : 50.0; };
    tree.copies = [](const TileId& id) { return id.level == 0 ? 0 : 100; };
    const CutMemory last;
    CutMemory now;
    const CutHistory history{.last = &last, .now = &now};
    const CutOptions all{};
    const auto whole = select(tiling, kEarth, view, all, 0.0, tree, &history);
    const CutOptions options{.copies_bytes = 400};
    const auto selection = select(tiling, kEarth, view, options, 0.0, tree, &history);
    std::set<int> split;
    for (const SelectedTile& tile : selection.drawn) {
      if (tile.id.level > 0) split.insert(tile.id.root);
    }
    const bool seen = std::any_of(whole.drawn.begin(), whole.drawn.end(),
                                  [&](const SelectedTile& tile) { return tile.id.root == worst && tile.id.level > 0; });
    EXPECT_EQ(split.size(), 1u);
    EXPECT_EQ(split.contains(worst), seen);
    EXPECT_EQ(whole.heldBack, 0);
    EXPECT_GT(selection.heldBack, 0);
  }
}

}  // namespace
}  // namespace tellurion::scene
