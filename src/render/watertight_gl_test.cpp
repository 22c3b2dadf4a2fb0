// The ground has no holes: a background that occurs nowhere else must not show wherever a ray is sure to meet the
// ground.

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/picking.h"
#include "scene/terrain_mesh.h"

namespace tellurion::render {
namespace {

constexpr int kCells = 16;
constexpr scene::Viewport kSize{160, 120};
constexpr std::array<float, 3> kMagenta{1.0f, 0.0f, 1.0f};

/// Rough ground of a fraction of the radius.
struct Relief {
  double amplitude_m;
  double operator()(const geo::Direction& d) const {
    const geo::Vec3 n = d.n * 23.0;
    return amplitude_m * std::sin(n.x + 2.0 * std::cos(n.y)) * std::cos(1.7 * n.z + n.x * n.y * 0.1);
  }
};

/// A tile as the scene makes them: vertices of neighbours agree to the last bit, coarse edges meet the parent's level.
scene::DrawnTile groundTile(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                            const synthetic::HeightFunction& height) {
  scene::GroundSamples samples(kCells + 3, kCells + 3);
  for (int row = 0; row <= kCells; ++row) {
    for (int col = 0; col <= kCells; ++col) {
      const geo::Direction d = tiling.direction(tiling::rootPointIn(id, 1.0 * col / kCells, 1.0 * row / kCells));
      samples.at(col + 1, row + 1) = static_cast<float>(height(d));
    }
  }
  scene::DrawnTile tile;
  tile.id = id;
  tile.mesh = scene::makeTerrainMesh(tiling, ellipsoid, scene::surfaceGrid(tiling, ellipsoid, id, samples)).mesh;
  return tile;
}

/// Tiles of two levels at random; each fine tile beside a coarse one gets its coarse edge.
std::vector<scene::DrawnTile> mixedLevels(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level,
                                          const synthetic::HeightFunction& height, std::mt19937_64& random) {
  std::set<tiling::TileId> refined;
  std::vector<tiling::TileId> all;
  const auto side = std::uint32_t{1} << static_cast<unsigned>(level);
  for (int root = 0; root < tiling.rootCount(); ++root) {
    for (std::uint32_t i = 0; i < side * side; ++i)
      all.push_back({static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(root), i % side, i / side});
  }
  for (const tiling::TileId& id : all) {
    if (random() % 2 == 0) refined.insert(id);
  }
  std::vector<scene::DrawnTile> tiles;
  for (const tiling::TileId& id : all) {
    if (!refined.contains(id)) {
      tiles.push_back(groundTile(tiling, ellipsoid, id, height));
      continue;
    }
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const tiling::TileId child = id.child(quadrant);
      tiles.push_back(groundTile(tiling, ellipsoid, child, height));
      for (const tiling::Edge edge : tiling::kEdges) {
        const tiling::TileId parent = tiling.edgeNeighbour(child, edge).tile.parent();
        if (parent != id && !refined.contains(parent))
          tiles.back().coarseEdges =
              static_cast<std::uint8_t>(tiles.back().coarseEdges | 1u << static_cast<unsigned>(edge));
      }
    }
  }
  return tiles;
}

/// How far a triangle may lie below a surface that its corners lie on: one with the longest side l reaches l / sqrt(3)
/// from its middle, so l^2 / 6R, a little more where l is not small beside R.
double deepestSag_m(const std::vector<scene::DrawnTile>& tiles, const geo::Ellipsoid& ellipsoid) {
  double longest_m = 0.0;
  for (const scene::DrawnTile& tile : tiles) {
    const auto& indices = tile.mesh->indices;
    const auto corner = [&](std::size_t i) { return tile.mesh->vertices[indices[i]].position_tile; };
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
      longest_m = std::max(longest_m, static_cast<double>(glm::length(corner(next) - corner(i))));
    }
  }
  const double b = ellipsoid.semiMinorAxis_m();
  const double leastRadius_m = b * b / ellipsoid.semiMajorAxis_m();
  return longest_m * longest_m / (5.0 * leastRadius_m);
}

scene::View randomView(const geo::Ellipsoid& ellipsoid, double highest_m, std::mt19937_64& random) {
  const double radius = ellipsoid.semiMajorAxis_m();
  const double height = highest_m + radius * std::pow(10.0, geo::uniform(random, -5.0, 0.5));
  const double lat = geo::Angle::radians(std::asin(geo::uniform(random, -1, 1))).degrees();
  return synthetic::viewAt(ellipsoid, lat, geo::uniform(random, -180, 180), height, geo::uniform(random, 0, 360),
                           geo::uniform(random, -90, 0), kSize, geo::uniform(random, 5, 100));
}

class Watertight : public synthetic::GlTest, public ::testing::WithParamInterface<tiling::Scheme> {
 protected:
  /// The number of pixels that show the sky although their rays meet the body lowered by `depth_m`.
  static int holesIn(const scene::Frame& frame, const geo::Ellipsoid& ellipsoid, double depth_m,
                     const RenderTarget& target) {
    const auto picture = readColour(target);
    const auto distances = readDistance(target, frame.view);
    int holes = 0;
    for (int row = 0; row < kSize.height; ++row) {
      for (int col = 0; col < kSize.width; ++col) {
        const raster::Rgba8 pixel = picture.at(col, row);
        const bool sky = pixel.r == 255 && pixel.g == 0 && pixel.b == 255;
        EXPECT_EQ(sky, std::isnan(distances.at(col, row)));
        if (!sky) continue;
        if (ellipsoid.intersect(scene::rayThrough(frame.view, {col + 0.5, row + 0.5}), -depth_m)) ++holes;
      }
    }
    return holes;
  }

  static void expectNoHoles(const geo::Ellipsoid& ellipsoid, int level, bool mixed, int views) {
    auto random = geo::seededGenerator();
    const tiling::Tiling tiling(GetParam());
    const double amplitude = 0.004 * ellipsoid.semiMajorAxis_m();
    const Relief relief{amplitude};
    scene::Frame frame;
    frame.background = kMagenta;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    frame.tiles =
        mixed ? mixedLevels(tiling, ellipsoid, level, relief, random) : oneLevel(tiling, ellipsoid, level, relief);
    const double depth = amplitude + deepestSag_m(frame.tiles, ellipsoid);
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    for (int i = 0; i < views; ++i) {
      frame.view = randomView(ellipsoid, amplitude, random);
      renderer.draw(frame, target);
      const int holes = holesIn(frame, ellipsoid, depth, target);
      const scene::Camera camera = scene::cameraOf(frame.view, ellipsoid);
      ASSERT_EQ(holes, 0) << "view " << i << " at " << camera.position.lat.degrees() << ", "
                          << camera.position.lon.degrees() << ", " << camera.position.height_m << " m";
    }
  }

  static std::vector<scene::DrawnTile> oneLevel(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid,
                                                int level, const synthetic::HeightFunction& height) {
    auto tiles = synthetic::wholeBody(tiling, ellipsoid, level, 2);
    for (scene::DrawnTile& tile : tiles)
      tile = groundTile(tiling, ellipsoid, tile.id, height);
    return tiles;
  }
};

TEST_P(Watertight, OneLevelOnEarth) {
  expectNoHoles(geo::earth().ellipsoid, 2, false, 60);
}

TEST_P(Watertight, FineBesideCoarseOnEarth) {
  expectNoHoles(geo::earth().ellipsoid, 1, true, 60);
}

TEST_P(Watertight, FineBesideCoarseOnATinyBody) {
  expectNoHoles(geo::Ellipsoid(250.0, 0.1), 1, true, 60);
}

// Tiles of 60 m, eye low above them and looking along them: every pixel below the horizon of the patch's own flat
// middle.
TEST_P(Watertight, DeepTilesUnderAnEyeTwoMetresUp) {
  auto random = geo::seededGenerator();
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  const auto bumps = [](const geo::Direction& d) { return 0.3 * std::sin(4e6 * d.n.x) * std::sin(4e6 * d.n.y); };
  constexpr int kLevel = 17;
  constexpr int kReach = 6;  // tiles around the middle one
  for (int place = 0; place < 4; ++place) {
    const tiling::TileId middle{kLevel, 0, static_cast<std::uint32_t>(random() % 100000 + 20),
                                static_cast<std::uint32_t>(random() % 60000 + 30000)};
    scene::Frame frame;
    frame.background = kMagenta;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    for (std::uint32_t y = middle.y - kReach; y <= middle.y + kReach; ++y) {
      for (std::uint32_t x = middle.x - kReach; x <= middle.x + kReach; ++x)
        frame.tiles.push_back(groundTile(tiling, ellipsoid, {kLevel, 0, x, y}, bumps));
    }
    const auto eye = geo::geodeticFromDirection(tiling.direction(tiling::rootPointIn(middle, 0.5, 0.5)));
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    for (int i = 0; i < 20; ++i) {
      // The top of the picture looks 3 degrees down or more: from 2 m, 40 m far.
      const double pitch = geo::uniform(random, -90, -23);
      frame.view = synthetic::viewAt(ellipsoid, eye.lat.degrees(), eye.lon.degrees(), 2.0, geo::uniform(random, 0, 360),
                                     pitch, kSize, 40);
      renderer.draw(frame, target);
      for (const raster::Rgba8& pixel : readColour(target).samples)
        ASSERT_FALSE(pixel.r == 255 && pixel.g == 0 && pixel.b == 255) << "place " << place << ", view " << i;
    }
  }
}

// Around a vertex of tiles thousands of kilometres wide: a rounding of one float beside it would be a hole of many
// pixels.
TEST_P(Watertight, LargeTilesUnderAnEyeTwoMetresUp) {
  auto random = geo::seededGenerator();
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  scene::Frame frame;
  frame.background = kMagenta;
  frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
  frame.tiles = oneLevel(tiling, ellipsoid, 2, Relief{9000.0});
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  for (int i = 0; i < 60; ++i) {
    const scene::TerrainMesh& mesh = *frame.tiles[random() % frame.tiles.size()].mesh;
    const std::uint32_t edge = mesh.fineEdge[random() % 4].first;  // its first triangle begins on the edge
    const auto vertex = mesh.origin + geo::Vec3(mesh.vertices[mesh.indices[edge]].position_tile);
    const geo::Geodetic at = ellipsoid.geodeticFromBody(vertex);
    frame.view = synthetic::viewAt(ellipsoid, at.lat.degrees(), at.lon.degrees(), at.height_m + 2.0,
                                   geo::uniform(random, 0, 360), -90, kSize, 60);
    renderer.draw(frame, target);
    int holes = 0;
    for (const raster::Rgba8& pixel : readColour(target).samples)
      holes += pixel.r == 255 && pixel.g == 0 && pixel.b == 255 ? 1 : 0;
    ASSERT_EQ(holes, 0) << "view " << i << " at " << at.lat.degrees() << ", " << at.lon.degrees();
  }
}

INSTANTIATE_TEST_SUITE_P(Schemes, Watertight,
                         ::testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& tested) { return std::string(tiling::nameOf(tested.param)); });

}  // namespace
}  // namespace tellurion::render
