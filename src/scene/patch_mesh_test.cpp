// What is drawn where no tile's own mesh fits has the sides of what lies beside it, to the last bit.

#include "scene/patch_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "geo/seed_test.h"
#include "scene/drawn_patches.h"
#include "scene/procedural_source_test.h"
#include "scene/terrain_mesh.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;

using Point = std::array<double, 3>;
using Sides = std::multiset<std::pair<Point, Point>>;

class PatchMeshOn : public testing::TestWithParam<Scheme> {
 protected:
  const tiling::Tiling tiling{GetParam()};
  const geo::Ellipsoid earth = geo::earth().ellipsoid;
  const double grid_m = vertexGrid_m(earth);
  ProceduralSource source{raster::Kind::elevation, GetParam(), 12};
  std::map<TileId, std::shared_ptr<const TerrainMesh>> made;

  const TerrainMesh& mesh(const TileId& id) {
    auto& known = made[id];
    if (known) return *known;
    GroundSamples heights = std::get<raster::ElevationTile>((*source.load(id))->payload).samples;
    for (float& height : heights.samples)
      height = raster::isNoData(height) ? 0.0f : height;
    const TerrainMesh* parent = id.level > 0 ? &mesh(id.parent()) : nullptr;
    known = makeTerrainMesh(tiling, earth, surfaceGrid(tiling, earth, id, heights), parent).mesh;
    return *known;
  }

  TileId randomTile(std::mt19937_64& random, int level) const {
    const double z = geo::uniform(random, -1, 1);
    return tiling.tileAt(geo::directionFromLatLon(geo::Angle::radians(std::asin(z)),
                                                  geo::Angle::degrees(geo::uniform(random, -180, 180))),
                         level);
  }

  void addSides(const TerrainMesh& of, const IndexRange& range, Sides& sides) const {
    const auto point = [&](std::uint32_t i) {
      const TerrainVertex& v = of.vertices[of.indices[i]];
      const geo::Vec3 p =
          of.origin.m + geo::Vec3(v.position_tile) + geo::Vec3(v.fine_tile[0], v.fine_tile[1], v.fine_tile[2]) * grid_m;
      return Point{p.x, p.y, p.z};
    };
    for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
      for (std::uint32_t k = 0; k < 3; ++k)
        sides.emplace(point(i + k), point(i + (k + 1) % 3));
    }
  }

  /// Those that no other triangle has the other way round: the outline.
  static Sides open(const Sides& sides) {
    Sides out;
    for (const auto& side : sides) {
      if (sides.count({side.second, side.first}) == 0) out.insert(side);
    }
    return out;
  }
};
INSTANTIATE_TEST_SUITE_P(All, PatchMeshOn, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

TEST_P(PatchMeshOn, fourPartsAreTheirTile) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 6; ++i) {
    const TerrainMesh& whole = mesh(randomTile(random, 1 + i));
    Sides ofWhole;
    addSides(whole, whole.interior, ofWhole);
    for (const IndexRange& edge : whole.fineEdge)
      addSides(whole, edge, ofWhole);
    Sides ofParts;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const auto part = patchMesh({.mesh = &whole, .quadrant = quadrant}, 0, {}, grid_m);
      addSides(*part, part->interior, ofParts);
      for (const TerrainVertex& v : part->vertices)
        EXPECT_EQ(v.toParent, (std::array<std::int16_t, 4>{}));
    }
    EXPECT_EQ(ofParts, ofWhole);
  }
}

TEST_P(PatchMeshOn, aTileIsJoinedToMuchFinerOnes) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 12;) {
    const int levels = 2 + static_cast<int>(random() % 3);
    const TileId fine = randomTile(random, 3 + levels);
    const auto edge = static_cast<std::uint8_t>(random() % 4);
    const TileId coarse = tiling.edgeNeighbour(fine, tiling::kEdges[edge]).tile.ancestor(3);
    if (fine.ancestor(3) == coarse) continue;
    ++i;
    FinerEdge finer = finerEdgeAlong(tiling, coarse, fine, edge);
    finer.finer = {.mesh = &mesh(fine)};
    const auto patch = patchMesh({.mesh = &mesh(coarse)}, 0, std::array{finer}, grid_m);
    Sides ofPatch;
    addSides(*patch, patch->interior, ofPatch);
    Sides ofFine;
    addSides(mesh(fine), mesh(fine).interior, ofFine);
    for (std::size_t e = 0; e < 4; ++e)
      addSides(mesh(fine), e == edge ? mesh(fine).coarseEdge[e] : mesh(fine).fineEdge[e], ofFine);
    std::size_t joined = 0;
    const Sides outline = open(ofPatch);
    for (const auto& side : open(ofFine))
      joined += outline.count({side.second, side.first});
    // As many as the finer one has there, which reach from one of its corners to the other.
    const auto& vertices = mesh(fine).vertices;
    std::set<std::uint16_t> onEdge;
    const IndexRange& range = mesh(fine).coarseEdge[edge];
    for (std::uint32_t k = range.first; k < range.first + range.count; ++k) {
      const TerrainVertex& v = vertices[mesh(fine).indices[k]];
      const int across = edge == 0 || edge == 2 ? v.t : v.s;
      if (across == (edge == 1 || edge == 2 ? kPlaceUnits : 0)) onEdge.insert(mesh(fine).indices[k]);
    }
    EXPECT_GE(onEdge.size(), 2u);
    EXPECT_EQ(joined, onEdge.size() - 1) << "levels apart: " << levels;
  }
}

}  // namespace
}  // namespace tellurion::scene
