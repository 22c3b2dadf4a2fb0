// A cut that is grown a part at a time (TilesAhead) is the one that is grown at once.

#include "scene/cut_growth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geo/seed_test.h"
#include "scene/fake_tree_test.h"

namespace tellurion::scene {
namespace {

/// Rough ground, of which tiles of the deeper levels are not here but for some.
FakeTree partlyLoaded(const tiling::Tiling& tiling, std::uint64_t seed) {
  const auto dice = [seed](const TileId& id) { return tiling::TileIdHash{}(id) ^ seed; };
  FakeTree tree(tiling);
  tree.deepest = tiling::kMaxLevel;
  tree.loaded = [dice](const TileId& id) { return id.level < 7 || dice(id) % 16 != 0; };
  tree.roughness = [dice](const TileId& id) { return (0.1 + static_cast<double>(dice(id) % 1000) / 1000.0) / 3.0; };
  return tree;
}

class CutGrowth : public testing::TestWithParam<tiling::Scheme> {};
INSTANTIATE_TEST_SUITE_P(All, CutGrowth,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(CutGrowth, inPartsIsAsAtOnce) {
  std::mt19937_64 random = geo::seededGenerator();
  const tiling::Tiling tiling(GetParam());
  std::size_t wanted = 0;
  std::size_t nodes = 0;
  for (int i = 0; i < 20; ++i) {
    FakeTree tree = partlyLoaded(tiling, random());
    const Camera camera{.position = {.lat = geo::Angle::radians(std::asin(geo::uniform(random, -1, 1))),
                                     .lon = geo::Angle::degrees(geo::uniform(random, -180, 180)),
                                     .height_m = 9500.0 + std::exp(geo::uniform(random, 0, 15))},
                        .heading = geo::Angle::degrees(geo::uniform(random, 0, 360)),
                        .pitch = geo::Angle::degrees(geo::uniform(random, -90, 0)),
                        .roll = {}};
    const View view = viewOf(camera, kEarth, geo::Angle::degrees(50.0), {.width = 1000, .height = 700});
    const CutOptions options{.tolerance_px = 0.3};
    const CutSight sight(view, kEarth, options, 500.0, options.morph, false);
    const CutPast past(nullptr);
    const GrowthRules rules{.tiling = tiling, .options = options, .sight = sight, .past = past, .tree = tree};
    GrowthBuffers whole;
    GrowthBuffers parts;
    Selection ofWhole;
    Selection ofParts;
    growRoots(rules, whole, ofWhole);
    growOn(rules, std::numeric_limits<std::size_t>::max(), whole, ofWhole);
    growRoots(rules, parts, ofParts);
    const std::size_t most = 1 + random() % 20;
    while (growOn(rules, most, parts, ofParts) == most)
      ;
    sortWanted(ofWhole.wanted);
    sortWanted(ofParts.wanted);
    wanted += ofWhole.wanted.size();
    nodes += whole.forest.nodes.size();
    ASSERT_EQ(ofParts.wanted.size(), ofWhole.wanted.size());
    for (std::size_t k = 0; k < ofWhole.wanted.size(); ++k) {
      ASSERT_EQ(ofParts.wanted[k].id, ofWhole.wanted[k].id);
      ASSERT_EQ(ofParts.wanted[k].priority, ofWhole.wanted[k].priority);
    }
    ASSERT_EQ(parts.forest.nodes.size(), whole.forest.nodes.size());
    for (std::size_t k = 0; k < whole.forest.nodes.size(); ++k)
      ASSERT_EQ(parts.forest.nodes[k].id, whole.forest.nodes[k].id);
  }
  EXPECT_GT(wanted, 20u);
  EXPECT_GT(nodes, 2000u);
}

}  // namespace
}  // namespace tellurion::scene
