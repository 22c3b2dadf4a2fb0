// The ground has no holes, however far its tiles have left their parents' surfaces and however high it is drawn: a
// background that occurs nowhere else must not show wherever a ray is sure to meet the ground.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "render/deepest_ground_test.h"
#include "render/synthetic_tiles_test.h"
#include "scene/corner_lattice.h"
#include "scene/drawn_vertex.h"
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

/// Tiles as the scene makes them: vertices of neighbours agree to the last bit, coarse edges meet the parent's level,
/// and all but the roots know the way to their parent's surface.
class GroundTiles {
 public:
  /// disagreement_m: by how much levels differ in the height of a place, as means of servers do.
  GroundTiles(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, synthetic::HeightFunction height,
              double disagreement_m = 0.0)
      : tiling_(tiling), ellipsoid_(ellipsoid), height_(std::move(height)), disagreement_m_(disagreement_m) {}

  scene::DrawnTile tile(const tiling::TileId& id) {
    scene::DrawnTile tile;
    tile.id = id;
    tile.mesh = mesh(id);
    return tile;
  }

  std::vector<scene::DrawnTile> oneLevel(int level) {
    std::vector<scene::DrawnTile> tiles;
    for (const tiling::TileId& id : idsOf(level))
      tiles.push_back(tile(id));
    return tiles;
  }

  std::vector<tiling::TileId> idsOf(int level) const {
    std::vector<tiling::TileId> all;
    const auto side = std::uint32_t{1} << static_cast<unsigned>(level);
    for (int root = 0; root < tiling_.rootCount(); ++root) {
      for (std::uint32_t i = 0; i < side * side; ++i)
        all.push_back({static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(root), i % side, i / side});
    }
    return all;
  }

  /// Tiles of two levels at random; each fine tile beside a coarse one gets its coarse edge.
  std::vector<scene::DrawnTile> mixedLevels(int level, std::mt19937_64& random) {
    const std::vector<tiling::TileId> all = idsOf(level);
    std::set<tiling::TileId> refined;
    for (const tiling::TileId& id : all) {
      if (random() % 2 == 0) refined.insert(id);
    }
    std::vector<scene::DrawnTile> tiles;
    for (const tiling::TileId& id : all) {
      if (!refined.contains(id)) {
        tiles.push_back(tile(id));
        continue;
      }
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        const tiling::TileId child = id.child(quadrant);
        tiles.push_back(tile(child));
        for (const tiling::Edge edge : tiling::kEdges) {
          const tiling::TileId parent = tiling_.edgeNeighbour(child, edge).tile.parent();
          if (parent != id && !refined.contains(parent))
            tiles.back().coarseEdges =
                static_cast<std::uint8_t>(tiles.back().coarseEdges | 1u << static_cast<unsigned>(edge));
        }
      }
    }
    return tiles;
  }

 private:
  std::shared_ptr<const scene::TerrainMesh> mesh(const tiling::TileId& id) {
    if (const auto found = meshes_.find(id); found != meshes_.end()) return found->second;
    const auto parent = id.level > 0 ? mesh(id.parent()) : nullptr;
    scene::GroundSamples samples(kCells + 3, kCells + 3);
    for (int row = 0; row <= kCells; ++row) {
      for (int col = 0; col <= kCells; ++col) {
        const geo::Direction d = tiling_.direction(tiling::rootPointIn(id, 1.0 * col / kCells, 1.0 * row / kCells));
        const double level_m = disagreement_m_ * std::sin(40.0 * id.level + 700.0 * d.n.x - 900.0 * d.n.y * d.n.z);
        samples.at(col + 1, row + 1) = static_cast<float>(height_(d) + level_m);
      }
    }
    const scene::SurfaceGrid grid = scene::surfaceGrid(tiling_, ellipsoid_, id, samples);
    return meshes_[id] = scene::makeTerrainMesh(tiling_, ellipsoid_, grid, parent.get()).mesh;
  }

  tiling::Tiling tiling_;
  geo::Ellipsoid ellipsoid_;
  synthetic::HeightFunction height_;
  double disagreement_m_;
  std::map<tiling::TileId, std::shared_ptr<const scene::TerrainMesh>> meshes_;
};

/// Heights once or three times as high, and every corner where tiles meet anywhere on the way from the parents'
/// surfaces, at its ends too; as the cut sets it, so that a corner of two levels is where both have the same surface.
void drawAtRandom(scene::Frame& frame, const tiling::Tiling& tiling, std::mt19937_64& random) {
  frame.exaggeration = random() % 2 == 0 ? 1.0 : 3.0;
  scene::CornerLattice corners;
  for (const scene::DrawnTile& tile : frame.tiles) {
    const double goal = std::clamp(geo::uniform(random, -1.5, 1.2), 0.0, 1.0);
    corners.add(scene::tileCorners(tiling, tile.id),
                {.id = tile.id, .coarseEdges = tile.coarseEdges, .goal = static_cast<float>(goal)});
  }
  corners.settle(nullptr, 1.0f);
  for (scene::DrawnTile& tile : frame.tiles) {
    const scene::TileCorners at = scene::tileCorners(tiling, tile.id);
    for (std::size_t q = 0; q < 4; ++q)
      tile.morph[q] = corners.valueAt(at[q], tile.id.level);
  }
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
  struct Looked {
    int pixels = 0;  ///< whose rays are sure to meet the ground
    int holes = 0;   ///< those of them that show the sky
  };
  /// Of a frame that draws the whole body.
  static Looked lookForHoles(const scene::Frame& frame, const geo::Ellipsoid& ellipsoid, const RenderTarget& target) {
    const double height_m = scene::cameraOf(frame.view, ellipsoid).position.height_m;
    const double farthest_m = std::sqrt(height_m * (height_m + 2.0 * ellipsoid.semiMajorAxis_m()));
    // Corners of triangles are drawn on a lattice of a 256th of a pixel.
    const double depth_m = deepestGround_m(frame, ellipsoid) + 0.02 * farthest_m * frame.view.pixelAngle();

    const auto picture = readColour(target);
    const auto distances = readDistance(target, frame.view);
    Looked looked;
    for (int row = 0; row < kSize.height; ++row) {
      for (int col = 0; col < kSize.width; ++col) {
        const raster::Rgba8 pixel = picture.at(col, row);
        const bool sky = pixel.r == 255 && pixel.g == 0 && pixel.b == 255;
        EXPECT_EQ(sky, std::isnan(distances.at(col, row)));
        if (!ellipsoid.intersect(scene::rayThrough(frame.view, {col + 0.5, row + 0.5}), -depth_m)) continue;
        ++looked.pixels;
        looked.holes += sky ? 1 : 0;
      }
    }
    return looked;
  }

  static void expectNoHoles(const geo::Ellipsoid& ellipsoid, int level, bool mixed, int views,
                            double disagreement_m = 0.0) {
    auto random = geo::seededGenerator();
    const tiling::Tiling tiling(GetParam());
    const double amplitude = 0.004 * ellipsoid.semiMajorAxis_m();
    GroundTiles ground(tiling, ellipsoid, Relief{amplitude}, disagreement_m);
    scene::Frame frame;
    frame.background = kMagenta;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    frame.tiles = mixed ? ground.mixedLevels(level, random) : ground.oneLevel(level);
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    int pixels = 0;
    for (int i = 0; i < views; ++i) {
      drawAtRandom(frame, tiling, random);
      frame.view = randomView(ellipsoid, (amplitude + disagreement_m) * frame.exaggeration, random);
      renderer.draw(frame, target);
      const Looked looked = lookForHoles(frame, ellipsoid, target);
      pixels += looked.pixels;
      const scene::Camera camera = scene::cameraOf(frame.view, ellipsoid);
      ASSERT_EQ(looked.holes, 0) << "view " << i << " at " << camera.position.lat.degrees() << ", "
                                 << camera.position.lon.degrees() << ", " << camera.position.height_m
                                 << " m, exaggeration " << frame.exaggeration;
    }
    EXPECT_GT(pixels, views * kSize.width * kSize.height / 4);
    std::printf("%d pixels looked at\n", pixels);
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

// What a server knows of coarse levels need not be what it knows of fine ones.
TEST_P(Watertight, FineBesideCoarseWhereLevelsDisagree) {
  expectNoHoles(geo::earth().ellipsoid, 1, true, 60, 60e3);
}

TEST_P(Watertight, FineBesideCoarseWhereLevelsDisagreeOnATinyBody) {
  expectNoHoles(geo::Ellipsoid(250.0, 0.1), 1, true, 60, 5.0);
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
    GroundTiles ground(tiling, ellipsoid, bumps);
    scene::Frame frame;
    frame.background = kMagenta;
    frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
    for (std::uint32_t y = middle.y - kReach; y <= middle.y + kReach; ++y) {
      for (std::uint32_t x = middle.x - kReach; x <= middle.x + kReach; ++x)
        frame.tiles.push_back(ground.tile({kLevel, 0, x, y}));
    }
    const auto eye = geo::geodeticFromDirection(tiling.direction(tiling::rootPointIn(middle, 0.5, 0.5)));
    Renderer renderer = makeRenderer();
    RenderTarget target = makeTarget(kSize);
    for (int i = 0; i < 20; ++i) {
      drawAtRandom(frame, tiling, random);
      // The top of the picture looks 3 degrees down or more: from 2 m over hollows of 0.9 m, 55 m far.
      const double pitch = geo::uniform(random, -90, -23);
      frame.view = synthetic::viewAt(ellipsoid, eye.lat.degrees(), eye.lon.degrees(), 2.0, geo::uniform(random, 0, 360),
                                     pitch, kSize, 40);
      renderer.draw(frame, target);
      for (const raster::Rgba8& pixel : readColour(target).samples)
        ASSERT_FALSE(pixel.r == 255 && pixel.g == 0 && pixel.b == 255) << "place " << place << ", view " << i;
    }
  }
}

// A wall seen along itself is nothing but needles, some of which turn over when their corners are rounded to the
// lattice that is drawn on: none of them may be lost, least of all where others are clipped at the picture's rim.
TEST_P(Watertight, AWallSeenAlongItself) {
  auto random = geo::seededGenerator();
  const tiling::Tiling tiling(GetParam());
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  constexpr int kLevel = 20;
  constexpr int kReach = 4;
  constexpr double kWall_m = 6.0;
  const tiling::TileId middle{kLevel, 0, 300000, 500000};
  const double step = tiling::tileSize(kLevel) / kCells;
  const double foot = middle.x * tiling::tileSize(kLevel) + 7 * step;
  GroundTiles ground(tiling, ellipsoid, [&](const geo::Direction& d) {
    return kWall_m * std::clamp((tiling.rootPoint(d).u - foot) / step, 0.0, 1.0);
  });
  scene::Frame frame;
  frame.background = kMagenta;
  frame.vertexGrid_m = scene::vertexGrid_m(ellipsoid);
  for (std::uint32_t y = middle.y - kReach; y <= middle.y + kReach; ++y) {
    for (std::uint32_t x = middle.x - kReach; x <= middle.x + kReach; ++x)
      frame.tiles.push_back(ground.tile({kLevel, 0, x, y}));
  }
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  for (int i = 0; i < 300; ++i) {
    // In the plane of the wall, twice as high.
    const double v = (middle.y + geo::uniform(random, 0, 1)) * tiling::tileSize(kLevel);
    const geo::BodyPosition eye = ellipsoid.bodyFromDirection(tiling.direction({0, foot + 2 * step, v}), 2 * kWall_m);
    const geo::BodyPosition along =
        ellipsoid.bodyFromDirection(tiling.direction({0, foot, v + geo::uniform(random, 2, 12) * step}), 0.0);
    const geo::Geodetic place = ellipsoid.geodeticFromBody(eye);
    const geo::LocalFrame local = geo::localFrameAt(ellipsoid, place);
    const geo::Vec3 look = geo::normalize(along - eye);
    frame.view = scene::viewOf(
        {.position = place,
         .heading = geo::Angle::radians(std::atan2(geo::dot(look, local.east), geo::dot(look, local.north))),
         .pitch = geo::Angle::radians(std::asin(geo::dot(look, local.up))),
         .roll = geo::Angle::degrees(geo::uniform(random, -30, 30))},
        ellipsoid, geo::Angle::degrees(30), kSize);
    renderer.draw(frame, target);
    int holes = 0;
    for (const raster::Rgba8& pixel : readColour(target).samples)
      holes += pixel.r == 255 && pixel.g == 0 && pixel.b == 255 ? 1 : 0;
    EXPECT_EQ(holes, 0) << "view " << i;
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
  frame.tiles = GroundTiles(tiling, ellipsoid, Relief{9000.0}).oneLevel(2);
  Renderer renderer = makeRenderer();
  RenderTarget target = makeTarget(kSize);
  for (int i = 0; i < 60; ++i) {
    drawAtRandom(frame, tiling, random);
    const scene::DrawnTile& tile = frame.tiles[random() % frame.tiles.size()];
    const std::uint32_t edge = tile.mesh->fineEdge[random() % 4].first;  // its first triangle begins on the edge
    const auto vertex = scene::drawnPosition(tile, tile.mesh->vertices[tile.mesh->indices[edge]], frame);
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
