// What the update of the cut costs, counted and not timed: tiles that it looks at for each that it draws.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <unordered_map>
#include <vector>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/select.h"
#include "scene/tile_content.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

/// Rough ground without an end, all of it loaded. Counts how often it is asked for children.
class RoughTree final : public TileTree {
 public:
  RoughTree(const Tiling& tiling, std::uint64_t seed) : tiling_(tiling), seed_(seed) {}

  long asked = 0;

  TileFacts* root(int root) override { return facts({.level = 0, .root = static_cast<std::uint8_t>(root)}); }
  std::array<TileFacts*, 4> children(const TileId& id, TileFacts&) override {
    ++asked;
    return {facts(id.child(0)), facts(id.child(1)), facts(id.child(2)), facts(id.child(3))};
  }

 private:
  TileFacts* facts(const TileId& id) {
    const auto [found, isNew] = facts_.try_emplace(id);
    if (isNew) {
      const double size_m = tiling_.metrics(id.level).meanEdge.radians() * kEarth.semiMajorAxis_m();
      const double roughness = static_cast<double>((tiling::TileIdHash{}(id) ^ seed_) % 1000) / 1000.0;
      TileFacts& f = found->second;
      f.drawable = true;
      f.box = f.tightBox = estimatedBox(tiling_, kEarth, id, {.low_m = -500.0, .high_m = 9000.0});
      f.corners = tileCorners(tiling_, id);
      f.around = tilesAround(tiling_, id);
      f.error_m = id.level < 20 ? 0.001 * size_m * (0.1 + roughness) : 0.0;
    }
    return &found->second;
  }

  Tiling tiling_;
  std::uint64_t seed_;
  std::unordered_map<TileId, TileFacts, tiling::TileIdHash> facts_;
};

class CutCost : public testing::TestWithParam<Scheme> {};

INSTANTIATE_TEST_SUITE_P(All, CutCost, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// Flights with a memory of the last frame, where ground out of view is kept as well, and half of them without.
TEST_P(CutCost, isBoundedByWhatIsDrawn) {
  // The way down from the roots and the ground around a picture that is small, whatever is drawn.
  constexpr double kAnyPicture = 500.0;
  constexpr double kATile = 3.0;
  std::mt19937_64 random = geo::seededGenerator();
  const Tiling tiling(GetParam());
  Selector selector(tiling, kEarth);
  double worst = 0.0;
  for (int flight = 0; flight < 30; ++flight) {
    RoughTree tree(tiling, random());
    std::array<CutMemory, 2> memories;
    CutHistory history{.last = &memories[0], .now = &memories[1], .step = 0.1};
    Camera camera{.position = {.lat = geo::Angle::radians(std::asin(geo::uniform(random, -1, 1))),
                               .lon = geo::Angle::degrees(geo::uniform(random, -180, 180)),
                               .height_m = 9500.0 + std::exp(geo::uniform(random, 0, 15))},
                  .heading = geo::Angle::degrees(geo::uniform(random, 0, 360)),
                  .pitch = geo::Angle::degrees(geo::uniform(random, -90, 0)),
                  .roll = {}};
    const CutOptions options{.tolerance_px = std::exp(geo::uniform(random, -1.5, 1.5)), .maxTiles = 1000000};
    for (int frame = 0; frame < 12; ++frame) {
      const View view = viewOf(camera, kEarth, geo::Angle::degrees(50.0), {.width = 1000, .height = 700});
      tree.asked = 0;
      const Selection& s = selector.select(view, options, 500.0, tree, flight % 2 == 0 ? &history : nullptr);
      ASSERT_TRUE(s.wanted.empty());
      const auto drawn = static_cast<double>(s.drawn.size());
      worst = std::max(worst, (s.visited - kAnyPicture) / std::max(drawn, 1.0));
      EXPECT_LE(s.visited, kAnyPicture + kATile * drawn) << drawn << " tiles drawn, flight " << flight;
      // Each split asks once, and what was split in the last frame up to twice whether it still is.
      EXPECT_LE(tree.asked, s.visited) << drawn << " tiles drawn, flight " << flight;
      std::swap(memories[0], memories[1]);
      camera.position.lat = camera.position.lat + geo::Angle::radians(camera.position.height_m * 1e-9);
      camera.heading = camera.heading + geo::Angle::degrees(2.0);
      camera.position.height_m = std::max(9100.0, camera.position.height_m * 0.99);
    }
  }
  std::printf("%.2f tiles looked at for a drawn one at most, beyond %.0f\n", worst, kAnyPicture);
}

}  // namespace
}  // namespace tellurion::scene
