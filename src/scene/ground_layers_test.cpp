#include "scene/ground_layers.h"

#include <gtest/gtest.h>

#include "geo/seed_test.h"
#include "scene/procedural_source_test.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

constexpr int kDepth = 9;

/// A high plain of 3,000 m with gentle hills, 0.6 degrees across, with a void in its middle; `far_m` at the antipodes.
struct HighPlain {
  explicit HighPlain(Scheme scheme, double baseHeight_m, double far_m)
      : tiling(scheme),
        random(geo::seededGenerator()),
        middle(geo::directionFromDegrees(geo::uniform(random, -80, 80), geo::uniform(random, -180, 180))),
        source(std::make_shared<ProceduralSource>(raster::Kind::elevation, scheme, kDepth)) {
    source->height = [=, this](const geo::Direction& d) {
      const double angle = geo::angleBetween(d, middle).degrees();
      if (angle > 175.0) return far_m;
      const bool isVoid = angle > 0.6 || angle < 0.1;
      return isVoid ? std::nan("") : baseHeight_m + 100.0 * std::sin(300.0 * d.n.x) * std::sin(300.0 * d.n.z);
    };
    source->heightBound_m = std::abs(baseHeight_m) + 100.0;
    source->heightRange_m = {baseHeight_m - 100.0, baseHeight_m + 100.0};
    if (!std::isnan(far_m)) {
      source->heightRange_m = {std::min(far_m, baseHeight_m - 100.0), std::max(far_m, baseHeight_m + 100.0)};
    }
    ground = std::make_unique<GroundLayers>(tiling,
                                            std::vector<GroundLayers::Layer>{std::make_shared<LayerTiles>(
                                                source, std::uint64_t{256} << 20, std::make_shared<LoadLedger>())},
                                            64);
  }

  /// Tiles of the deepest level through a place, and some next to it.
  std::vector<TileId> around(const geo::Direction& d) const {
    const TileId id = tiling.tileAt(d, kDepth);
    std::vector<TileId> tiles{id};
    for (const tiling::Edge e : tiling::kEdges)
      tiles.push_back(tiling.edgeNeighbour(id, e).tile);
    return tiles;
  }
  double angleOf(const TileId& id, int col, int row) const {
    return geo::angleBetween(tiling.direction(tiling::rootPointIn(id, col / 64.0, row / 64.0)), middle).degrees();
  }

  Tiling tiling;
  std::mt19937_64 random;
  geo::Direction middle;
  std::shared_ptr<ProceduralSource> source;
  std::unique_ptr<GroundLayers> ground;
};

/// The largest step between two samples next to each other, of those nearer than `degrees` to the middle.
double worstStep(const HighPlain& plain, const TileId& id, double degrees) {
  const GroundSamples heights = plain.ground->compose(id).heights;
  double worst = 0.0;
  for (int row = 0; row < 64; ++row) {
    for (int col = 0; col < 64; ++col) {
      if (plain.angleOf(id, col, row) > degrees) continue;
      const auto at = [&](int c, int r) { return static_cast<double>(heights.at(c + 1, r + 1)); };
      worst = std::max(worst, std::abs(at(col + 1, row) - at(col, row)));
      worst = std::max(worst, std::abs(at(col, row + 1) - at(col, row)));
    }
  }
  return worst;
}

class GroundOnTiling : public testing::TestWithParam<Scheme> {};
INSTANTIATE_TEST_SUITE_P(All, GroundOnTiling, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(GroundOnTiling, aVoidTakesItsRimsHeights) {
  const HighPlain plain(GetParam(), 3000.0, 0.0);
  int inVoid = 0;
  for (const TileId& id : plain.around(plain.middle)) {
    const ComposedGround ground = plain.ground->compose(id);
    EXPECT_LT(worstStep(plain, id, 0.4), 250.0) << "a shaft";
    for (int row = 0; row <= 64; ++row) {
      for (int col = 0; col <= 64; ++col) {
        if (plain.angleOf(id, col, row) > 0.1) continue;
        ++inVoid;
        EXPECT_NEAR(static_cast<double>(ground.heights.at(col + 1, row + 1)), 3000.0, 101.0);
      }
    }
  }
  EXPECT_GT(inVoid, 100);
}

TEST_P(GroundOnTiling, theGroundBeyondTheBorderMeetsIt) {
  for (const double height_m : {3000.0, -4500.0}) {
    HighPlain plain(GetParam(), height_m, 0.0);
    for (int i = 0; i < 4; ++i) {
      const geo::Vec3 side = geo::normalize(
          geo::cross(plain.middle.n, geo::Vec3(geo::uniform(plain.random, -1, 1), geo::uniform(plain.random, -1, 1),
                                               geo::uniform(plain.random, -1, 1))));
      const geo::Direction border{geo::normalize(plain.middle.n + std::tan(0.6 * geo::kPi / 180.0) * side)};
      for (const TileId& id : plain.around(border)) {
        if (plain.ground->compose(id).level < kDepth) continue;
        // A wall down to the ellipsoid would be as high as the plain.
        EXPECT_LT(worstStep(plain, id, 0.7), 0.2 * std::abs(height_m));
      }
    }
  }
}

TEST_P(GroundOnTiling, farFromAllDataTheGroundHasTheHeightNearestToTheEllipsoid) {
  for (const double height_m : {3000.0, -4500.0}) {
    // Nothing at sea level anywhere: the whole body takes the nearest height that there is.
    const HighPlain plain(GetParam(), height_m, std::nan(""));
    const TileId id = plain.tiling.tileAt(geo::Direction{-plain.middle.n}, 2);
    const auto far_m = static_cast<double>(plain.ground->compose(id).heights.at(30, 30));
    EXPECT_EQ(far_m, height_m > 0.0 ? height_m - 100.0 : height_m + 100.0);
  }
  const HighPlain both(GetParam(), 3000.0, -20.0);
  const geo::Direction aside{geo::normalize(geo::cross(both.middle.n, geo::Vec3(0.3, 0.2, 0.9)))};
  EXPECT_EQ(both.ground->compose(both.tiling.tileAt(aside, 2)).heights.at(30, 30), 0.0f);
}

TEST_P(GroundOnTiling, samplesOfParentsAreSamplesOfTheirChildrenAlsoWithoutData) {
  const HighPlain plain(GetParam(), 3000.0, 0.0);
  for (int level = 3; level < kDepth; ++level) {
    const TileId id = plain.tiling.tileAt(plain.middle, level);
    const ComposedGround parent = plain.ground->compose(id);
    for (int q = 0; q < 4; ++q) {
      const ComposedGround child = plain.ground->compose(id.child(q), &parent.heights);
      if (child.level < level + 1) continue;
      for (int row = 1; row < 32; ++row) {
        for (int col = 1; col < 32; ++col) {
          ASSERT_EQ(child.heights.at(2 * col + 1, 2 * row + 1),
                    parent.heights.at((q & 1) * 32 + col + 1, (q >> 1) * 32 + row + 1));
        }
      }
    }
  }
}

/// A plateau of 3,000 m, half a degree round, on a planet at sea level.
TEST(GroundLayersSeam, aLocalModelEndsInASlopeAsWideAsTheSeam) {
  const Tiling tiling(Scheme::cube);
  const geo::Direction middle = geo::directionFromDegrees(46, 8);
  constexpr double kRadius_degrees = 0.5;
  const auto planet = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, 4);
  planet->height = [](const geo::Direction&) { return 0.0; };
  const auto model = std::make_shared<ProceduralSource>(raster::Kind::elevation, Scheme::cube, kDepth);
  model->height = [&](const geo::Direction& d) {
    return geo::angleBetween(d, middle).degrees() < kRadius_degrees ? 3000.0 : std::nan("");
  };
  model->setBounds(geo::GeoRect::fromDegrees(45.5, 7.28, 46.5, 8.72));
  const auto tiles = [](const auto& source) {
    return std::make_shared<LayerTiles>(source, std::uint64_t{256} << 20, std::make_shared<LoadLedger>());
  };
  constexpr double kSeam_m = 10e3;
  for (const double seam_m : {0.0, kSeam_m}) {
    const GroundLayers ground(tiling, {{tiles(planet)}, {tiles(model), seam_m}}, 64);
    double steepest_m = 0.0;
    double highest_m = 0.0;
    for (int i = 0; i < 60; ++i) {
      // Across the border to the east.
      const TileId id = tiling.tileAt(geo::directionFromDegrees(46, 8.0 + 0.9 * i / 60.0), kDepth);
      const GroundSamples heights = ground.compose(id).heights;
      for (int row = 1; row < 66; ++row) {
        for (int col = 2; col < 66; ++col)
          steepest_m = std::max(steepest_m, std::abs(double(heights.at(col, row)) - double(heights.at(col - 1, row))));
      }
      highest_m = std::max(highest_m, double(heights.at(33, 33)));
    }
    EXPECT_EQ(highest_m, 3000.0);
    const double spacing_m = tiling.metrics(kDepth).largestEdge.radians() / 64 * 6378137.0;
    if (seam_m == 0.0) {
      EXPECT_EQ(steepest_m, 3000.0);
    } else {
      EXPECT_LT(steepest_m, 1.6 * 3000.0 * spacing_m / kSeam_m);
      EXPECT_GT(steepest_m, 0.5 * 3000.0 * spacing_m / kSeam_m);
    }
  }
}

}  // namespace
}  // namespace tellurion::scene
