// What was drawn decides how the cut goes on: without a jump, and without fluttering.
#include "scene/cut_past.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "geo/seed_test.h"
#include "scene/globe.h"
#include "scene/procedural_source_test.h"
#include "scene/view_from_test.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

/// Four facts below one tile, their corners the tiling's own.
struct Family {
  Family(const Tiling& tiling, const TileId& parent) {
    over.corners = tileCorners(tiling, parent);
    for (int q = 0; q < 4; ++q) {
      below[static_cast<std::size_t>(q)].corners = tileCorners(tiling, parent.child(q));
      children[static_cast<std::size_t>(q)] = &below[static_cast<std::size_t>(q)];
    }
  }
  TileFacts over;
  std::array<TileFacts, 4> below;
  TileChildren children{};
};

class CutPastOn : public testing::TestWithParam<Scheme> {
 protected:
  const Tiling tiling{GetParam()};
  const TileId root{.level = 0, .root = 3};
  Family family{tiling, root};
  CutMemory last;
  CutMemory now;
  const CutHistory history{.last = &last, .now = &now};
  const CutPast past{&history};

  CutNode node() {
    CutNode made(&family.over, -1);
    made.id = root;
    past.recall(made, nullptr);
    return made;
  }
  /// The last frame drew one tile, its corners this far from the parent's surface.
  void drew(const TileId& id, const TileFacts& facts, float morph) {
    last.corners.add(facts.corners, {.id = id, .goal = morph});
  }
  void drewTheRoot(float morph) {
    last.start(static_cast<std::size_t>(tiling.rootCount()));
    last.set(root.root, CutMemory::Was::leaf, -1);
    drew(root, family.over, morph);
    last.corners.settle(nullptr, 1.0f);
  }
  void drewTheChildren(const std::array<float, 4>& morph) {
    const int first = tiling.rootCount();
    last.start(static_cast<std::size_t>(first) + 4);
    last.set(root.root, CutMemory::Was::split, first);
    for (int q = 0; q < 4; ++q) {
      last.set(first + q, CutMemory::Was::leaf, -1);
      drew(root.child(q), family.below[static_cast<std::size_t>(q)], morph[static_cast<std::size_t>(q)]);
    }
    last.corners.settle(nullptr, 1.0f);
  }
};
INSTANTIATE_TEST_SUITE_P(All, CutPastOn, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(CutPastOn, nothingIsWaitedForWhereNothingIsKnown) {
  const CutPast none(nullptr);
  CutNode made(&family.over, -1);
  made.id = root;
  none.recall(made, nullptr);
  EXPECT_FALSE(none.isKnown());
  EXPECT_EQ(made.before, Before::nowhere);
  EXPECT_TRUE(none.mayPart(made, family.children));
}

TEST_P(CutPastOn, aTilePartsOnlyWhenItHasWhollyLeftItsParentsSurface) {
  for (const float morph : {0.0f, 0.5f, 0.999f, 1.0f}) {
    last.corners.clear();
    drewTheRoot(morph);
    const CutNode made = node();
    EXPECT_EQ(made.before, Before::here);
    EXPECT_EQ(past.mayPart(made, family.children), morph >= 1.0f) << morph;
  }
}

TEST_P(CutPastOn, childrenBecomeTheirParentOnlyWhenAllAreBackOnItsSurface) {
  for (const std::array<float, 4> morph :
       {std::array{0.0f, 0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 0.25f}, {1, 1, 1, 1}}) {
    last.corners.clear();
    drewTheChildren(morph);
    const CutNode made = node();
    EXPECT_EQ(made.before, Before::below);
    EXPECT_TRUE(past.mayPart(made, family.children)) << "what was drawn finer stays so at once";
    EXPECT_EQ(past.isBackOnItsSurface(made, family.children), morph[3] == 0.0f) << morph[3];
    CutNode child(family.children[0], 0);
    child.id = root.child(0);
    past.recall(child, &made);
    EXPECT_EQ(child.before, Before::here);
  }
}

TEST_P(CutPastOn, whatIsFinerThanItWasDrawnCannotPartAtOnce) {
  drewTheRoot(1.0f);
  const CutNode over = node();
  CutNode child(family.children[2], 0);
  child.id = root.child(2);
  past.recall(child, &over);
  EXPECT_EQ(child.before, Before::above);
  const Family finer(tiling, child.id);
  EXPECT_FALSE(past.mayPart(child, finer.children));
}

/// Of an eye that goes to and fro over the height where tiles part, nothing that is drawn jumps, and tiles neither part
/// nor join more often than the eye crosses.
TEST_P(CutPastOn, anEyeGoingToAndFroOverAThresholdShowsNothing) {
  Scene planet;
  planet.tiling = GetParam();
  const auto source = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 7);
  const auto globe = Globe::fromLayers(planet, {.elevation = {source}, .imagery = {}}).value();
  double time_s = 0.0;
  const auto look = [&](double height_m) -> const Frame& {
    time_s += 1.0 / 60.0;
    return globe->update(viewFrom(46.6, 8.0, height_m, 20, -40), {.tolerance_px = 2.0, .time_s = time_s});
  };
  const auto settle = [&](double height_m) {
    const Frame* frame = &look(height_m);
    for (int i = 0; i < 3000 && !frame->complete; ++i) {
      globe->waitForArrivals(std::chrono::milliseconds(20));
      frame = &look(height_m);
    }
    ASSERT_TRUE(frame->complete);
  };
  settle(78e3);
  settle(82e3);
  std::set<TileId> before;
  for (const DrawnTile& tile : look(82e3).tiles)
    before.insert(tile.id);
  constexpr int kPeriod = 40;  // frames
  constexpr int kPeriods = 6;
  std::map<TileId, int> came;
  float largestStep = 0.0f;
  std::map<TileId, std::array<float, 4>> morphs;
  for (int i = 0; i < kPeriod * kPeriods; ++i) {
    const Frame& frame = look(80e3 + 2e3 * std::cos(2.0 * geo::kPi * i / kPeriod));
    std::map<TileId, std::array<float, 4>> drawn;
    for (const DrawnTile& tile : frame.tiles) {
      drawn.emplace(tile.id, tile.morph);
      const auto was = morphs.find(tile.id);
      if (was == morphs.end()) {
        came[tile.id] += i > 0 ? 1 : 0;
        continue;
      }
      for (std::size_t c = 0; c < 4; ++c)
        largestStep = std::max(largestStep, std::abs(tile.morph[c] - was->second[c]));
    }
    morphs = std::move(drawn);
  }
  EXPECT_GT(came.size(), 0u) << "no tile parts between these heights";
  for (const auto& [id, times] : came)
    EXPECT_LE(times, kPeriods) << "level " << id.level << ", fluttering";
  EXPECT_LT(largestStep, 0.5f);
}

}  // namespace
}  // namespace tellurion::scene
