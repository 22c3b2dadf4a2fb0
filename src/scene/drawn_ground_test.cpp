#include "scene/drawn_ground.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "geo/body.h"
#include "scene/drawn_vertex.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

constexpr int kCells = 32;
constexpr tiling::TileId kTile{14, 1, 5000, 9000};

// A plane in tile coordinates that rises over the whole tile, so that every triangle of the mesh lies close to it.
double slope_m(double s, double t) {
  return 1000.0 + 300.0 * s - 200.0 * t;
}

GroundSamples sloping() {
  GroundSamples heights(kCells + 3, kCells + 3);
  for (int row = 0; row < heights.height; ++row)
    for (int col = 0; col < heights.width; ++col)
      heights.at(col, row) = static_cast<float>(slope_m((col - 1.0) / kCells, (row - 1.0) / kCells));
  return heights;
}

struct Drawn {
  Frame frame;
  double error_m = 0.0;  ///< how far the triangles may lie from the samples
};

Drawn drawn(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, unsigned coarseEdges) {
  const MadeMesh made = makeTerrainMesh(tiling, ellipsoid, surfaceGrid(tiling, ellipsoid, kTile, sloping()));
  DrawnTile tile;
  tile.id = kTile;
  tile.mesh = made.mesh;
  tile.coarseEdges = static_cast<std::uint8_t>(coarseEdges);
  Drawn result;
  result.frame.tiles.push_back(tile);
  result.error_m = made.error_m;
  return result;
}

class DrawnGround : public testing::TestWithParam<tiling::Scheme> {};

TEST_P(DrawnGround, IsTheHeightOfTheTrianglesAtEveryPlaceOfTheTile) {
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (const unsigned coarse : {0u, 5u, 15u}) {
    const Drawn drawing = drawn(tiling, ellipsoid, coarse);
    EXPECT_LT(drawing.error_m, 30.0) << "else the test says nothing";
    for (int i = 0; i < 300; ++i) {
      SCOPED_TRACE(testing::Message() << "seed " << kSeed << ", case " << i);
      const double s = i < 10 ? 0.0 : share(random), t = i < 20 && i >= 10 ? 1.0 : share(random);
      const geo::Direction place = tiling.direction(tiling::rootPointIn(kTile, s, t));
      const auto height = drawnHeight_m(drawing.frame, tiling, ellipsoid, place);
      ASSERT_TRUE(height) << s << " " << t;
      EXPECT_NEAR(*height, slope_m(s, t), drawing.error_m + 0.1)
          << "vertices lie within a unit of 1 / 32768 of the tile";
    }
  }
}

/// Where the vertical at a place meets a triangle, as a height over the ellipsoid along that vertical.
std::optional<double> heightOnVertical(const std::array<geo::Vec3, 3>& corners, const geo::Vec3& foot,
                                       const geo::Vec3& up) {
  const geo::Vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0], over = geo::cross(up, ac);
  const double area = geo::dot(ab, over);
  if (area == 0.0) return std::nullopt;
  const geo::Vec3 to = foot - corners[0];
  const double b = geo::dot(to, over) / area, c = geo::dot(up, geo::cross(to, ab)) / area;
  if (std::min({b, c, 1.0 - b - c}) < 0.0) return std::nullopt;
  return geo::dot(ac, geo::cross(to, ab)) / area;
}

// Exaggerated chords of a large tile stand kilometres beside their places.
TEST_P(DrawnGround, IsOnTheVerticalOfItsPlaceHoweverLargeTheTriangles) {
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  constexpr tiling::TileId kLarge{3, 1, 3, 4};
  GroundSamples heights = sloping();
  for (float& h : heights.samples)
    h = 8.0f * h - 12000.0f;
  const MadeMesh made = makeTerrainMesh(tiling, ellipsoid, surfaceGrid(tiling, ellipsoid, kLarge, heights));
  Frame frame;
  frame.exaggeration = 35.0;
  frame.tiles.push_back({.id = kLarge, .mesh = made.mesh});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.2, 0.8);
  for (int i = 0; i < 200; ++i) {
    const geo::Direction place = tiling.direction(tiling::rootPointIn(kLarge, share(random), share(random)));
    const auto height = drawnHeight_m(frame, tiling, ellipsoid, place);
    ASSERT_TRUE(height);
    geo::Geodetic at = geo::geodeticFromDirection(place);
    at.height_m = 0.0;
    double nearest_m = HUGE_VAL;
    const auto meet = [&](const IndexRange& range) {
      for (std::uint32_t k = range.first; k + 2 < range.first + range.count; k += 3) {
        std::array<geo::Vec3, 3> corners;
        for (std::uint32_t j = 0; j < 3; ++j)
          corners[j] = drawnPosition(frame.tiles[0], made.mesh->vertices[made.mesh->indices[k + j]], frame).m;
        const auto met = heightOnVertical(corners, ellipsoid.bodyFromGeodetic(at).m, place.n);
        if (met) nearest_m = std::min(nearest_m, std::abs(*met - *height));
      }
    };
    meet(made.mesh->interior);
    for (const IndexRange& edge : made.mesh->fineEdge)
      meet(edge);
    EXPECT_LT(nearest_m, 0.1) << "case " << i;
  }
}

TEST_P(DrawnGround, NothingWhereNothingIsDrawn) {
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  const Frame frame = drawn(tiling, ellipsoid, 0).frame;
  EXPECT_FALSE(drawnHeight_m(frame, tiling, ellipsoid, tiling.direction(tiling::rootPointIn(kTile, 1.5, 0.5))));
  EXPECT_FALSE(drawnHeight_m(frame, tiling, ellipsoid, tiling.direction({0, 0.5, 0.5})));
  EXPECT_FALSE(drawnHeight_m(Frame{}, tiling, ellipsoid, tiling.direction({0, 0.5, 0.5})));
}

INSTANTIATE_TEST_SUITE_P(Schemes, DrawnGround,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

}  // namespace
}  // namespace tellurion::scene
