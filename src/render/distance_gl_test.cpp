// Distances of drawn bodies against rays met with the same triangles in double precision, and with the ellipsoid.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace {

using synthetic::viewAt;

class Distance : public synthetic::GlTest {};

struct Triangle {
  geo::Vec3 a, b, c;
};

/// What the tiles' fine edges and interiors draw, relative to the eye.
std::vector<Triangle> trianglesOf(const std::vector<scene::DrawnTile>& tiles, const geo::BodyPosition& eye) {
  std::vector<Triangle> triangles;
  for (const scene::DrawnTile& tile : tiles) {
    const scene::TerrainMesh& mesh = *tile.mesh;
    const geo::Vec3 origin = mesh.origin - eye;
    const auto at = [&](std::size_t i) { return origin + geo::Vec3(mesh.vertices[mesh.indices[i]].position_tile); };
    std::vector<scene::IndexRange> ranges{mesh.interior};
    ranges.insert(ranges.end(), mesh.fineEdge.begin(), mesh.fineEdge.end());
    for (const scene::IndexRange& range : ranges) {
      for (std::size_t i = range.first; i < range.first + range.count; i += 3)
        triangles.push_back({at(i), at(i + 1), at(i + 2)});
    }
  }
  return triangles;
}

/// Distance along a unit direction from the origin to a triangle seen from its front (Moeller and Trumbore 1997).
double distanceTo(const Triangle& t, const geo::Vec3& direction) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const geo::Vec3 ab = t.b - t.a;
  const geo::Vec3 ac = t.c - t.a;
  const geo::Vec3 p = geo::cross(direction, ac);
  const double determinant = geo::dot(ab, p);
  if (!(determinant > 0.0)) return kNone;
  const double u = geo::dot(-t.a, p);
  const geo::Vec3 q = geo::cross(-t.a, ab);
  const double v = geo::dot(direction, q);
  if (u < 0.0 || v < 0.0 || u + v > determinant) return kNone;
  const double along = geo::dot(ac, q) / determinant;
  return along > 0.0 ? along : kNone;
}

double nearest(const std::vector<Triangle>& triangles, const geo::Vec3& direction) {
  double best = std::numeric_limits<double>::infinity();
  for (const Triangle& t : triangles)
    best = std::min(best, distanceTo(t, direction));
  return best;
}

struct Spread {
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
};

/// Over the pixel's centre and four places beside it, further than a GPU's vertex grid of 1/256 pixel moves an edge.
template <class Least, class Most>
Spread spreadAround(const scene::View& view, int col, int row, const Least& least, const Most& most) {
  constexpr double kShift_px = 0.01;
  constexpr std::array<std::array<double, 2>, 5> kPlaces{{{0, 0}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};
  Spread spread;
  for (const auto& place : kPlaces) {
    const geo::Ray ray = scene::rayThrough(view, {col + 0.5 + kShift_px * place[0], row + 0.5 + kShift_px * place[1]});
    spread.least = std::min(spread.least, least(ray));
    spread.most = std::max(spread.most, most(ray));
  }
  return spread;
}

Spread spreadOf(const std::vector<Triangle>& triangles, const scene::View& view, int col, int row) {
  const auto distance = [&](const geo::Ray& ray) { return nearest(triangles, ray.direction); };
  return spreadAround(view, col, row, distance, distance);
}

/// From the ellipsoid raised by `upper_m` to the one raised by `lower_m`.
Spread spreadBetween(const geo::Ellipsoid& ellipsoid, double upper_m, double lower_m, const scene::View& view, int col,
                     int row) {
  const auto distanceTo = [&](double height_m) {
    return [&ellipsoid, height_m](const geo::Ray& ray) {
      return ellipsoid.intersect(ray, height_m).value_or(std::numeric_limits<double>::infinity());
    };
  };
  return spreadAround(view, col, row, distanceTo(upper_m), distanceTo(lower_m));
}

scene::Frame frameOf(const scene::View& view, std::vector<scene::DrawnTile> tiles) {
  scene::Frame frame;
  frame.view = view;
  frame.tiles = std::move(tiles);
  return frame;
}

TEST_F(Distance, OfEveryPixelIsThatOfItsTriangle) {
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const geo::Ellipsoid ellipsoid(1e4, 1.0 / 50.0);
  const auto bumps = [](const geo::Direction& d) { return 150.0 * std::sin(9 * d.n.x) * std::cos(7 * d.n.y + d.n.z); };
  const auto tiles = synthetic::wholeBody(tiling, ellipsoid, 1, 8, bumps);
  Renderer renderer = makeRenderer();
  const scene::Viewport size{48, 36};
  RenderTarget target = makeTarget(size);
  const std::array views{
      viewAt(ellipsoid, 10, 20, 30e3, 0, -90, size), viewAt(ellipsoid, -50, 179, 500, 120, -10, size, 60),
      viewAt(ellipsoid, 89.9, 0, 300, 30, -30, size), viewAt(ellipsoid, 0, -90, 1e6, 0, -90, size, 1.2)};
  for (const scene::View& view : views) {
    renderer.draw(frameOf(view, tiles), target);
    const auto distances = readDistance(target, view);
    const auto triangles = trianglesOf(tiles, view.eye);
    int ground = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int col = 0; col < size.width; ++col) {
        const Spread spread = spreadOf(triangles, view, col, row);
        const double d = static_cast<double>(distances.at(col, row));
        if (std::isnan(d)) {
          EXPECT_TRUE(std::isinf(spread.most)) << "a hole at " << col << ", " << row;
          continue;
        }
        ++ground;
        EXPECT_GE(d, spread.least * (1.0 - 1e-6)) << col << ", " << row;
        EXPECT_LE(d, spread.most * (1.0 + 1e-6)) << col << ", " << row;
      }
    }
    EXPECT_GT(ground, size.width * size.height / 10);
  }
}

// The drawn chords lie between the ellipsoid and the ellipsoid lowered by their sag.
TEST_F(Distance, OfEarthIsTheEllipsoidsFromTwoMetresToAMillionKilometres) {
  const tiling::Tiling tiling(tiling::Scheme::cube);
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  constexpr int kLevel = 3;
  constexpr int kCells = 32;
  const auto tiles = synthetic::wholeBody(tiling, ellipsoid, kLevel, kCells);
  const double diagonal_m = 1.5 * tiling.metrics(kLevel).largestEdge.radians() * ellipsoid.semiMajorAxis_m() / kCells;
  constexpr double kVertexGrid_m = 0.5;  // of floats this far from a tile's middle
  const double sag_m = diagonal_m * diagonal_m / (8.0 * ellipsoid.semiMinorAxis_m()) + kVertexGrid_m;
  const scene::Viewport size{96, 64};
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(size);
  const double fovFar = 0.5;
  const std::array views{viewAt(ellipsoid, 47, 8, 2.0, 0, -90, size), viewAt(ellipsoid, 47, 8, 2e4, 0, -60, size),
                         viewAt(ellipsoid, 0, 180, 3e5, 45, -20, size), viewAt(ellipsoid, 90, 0, 8e6, 0, -90, size),
                         viewAt(ellipsoid, -30, -60, 1e9, 0, -90, size, fovFar)};
  for (const scene::View& view : views) {
    renderer.draw(frameOf(view, tiles), target);
    const auto distances = readDistance(target, view);
    int compared = 0;
    for (int row = 0; row < size.height; ++row) {
      for (int col = 0; col < size.width; ++col) {
        const double d = static_cast<double>(distances.at(col, row));
        const Spread spread = spreadBetween(ellipsoid, kVertexGrid_m, -sag_m, view, col, row);
        if (std::isnan(d)) {
          EXPECT_TRUE(std::isinf(spread.most)) << "a hole at " << col << ", " << row;
          continue;
        }
        EXPECT_GE(d, spread.least * (1.0 - 1e-6)) << col << ", " << row;
        EXPECT_LE(d, spread.most * (1.0 + 1e-6)) << col << ", " << row;
        ++compared;
      }
    }
    EXPECT_GT(compared, size.width * size.height / 4);
  }
}

TEST_F(Distance, AtOnePlaceIsThatOfItsPixel) {
  const tiling::Tiling tiling(tiling::Scheme::healpix);
  const geo::Ellipsoid ellipsoid = geo::moon().ellipsoid;
  const scene::Viewport size{40, 30};
  const scene::View view = viewAt(ellipsoid, 5, 5, 3e6, 0, -90, size, 70);
  RenderTarget target = makeTarget(size);
  makeRenderer().draw(frameOf(view, synthetic::wholeBody(tiling, ellipsoid, 1, 8)), target);
  const auto distances = readDistance(target, view);
  for (int row = 0; row < size.height; ++row) {
    for (int col = 0; col < size.width; ++col) {
      const auto one = readDistanceAt(target, view, {col + 0.3, row + 0.8});
      EXPECT_EQ(one.has_value(), !std::isnan(distances.at(col, row)));
      if (one) {
        EXPECT_EQ(static_cast<float>(*one), distances.at(col, row));
      }
    }
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const scene::PixelPosition outside : {scene::PixelPosition{-0.1, 3}, {3, -0.1}, {40, 3}, {3, 30}, {nan, 3}})
    EXPECT_EQ(readDistanceAt(target, view, outside), std::nullopt);
}

TEST_F(Distance, OfSkyIsNan) {
  const scene::Viewport size{8, 8};
  const scene::View view = viewAt(geo::earth().ellipsoid, 0, 0, 100, 0, 90, size);
  RenderTarget target = makeTarget(size);
  makeRenderer().draw(frameOf(view, {}), target);
  for (const float d : readDistance(target, view).samples)
    EXPECT_TRUE(std::isnan(d));
}

}  // namespace
}  // namespace tellurion::render
