#include "scene/terrain_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/bisection.h"
#include "scene/corner_lattice.h"
#include "scene/drawn_vertex.h"
#include "scene/ground_layers.h"
#include "scene/procedural_source_test.h"
#include "scene/relief.h"
#include "scene/tile_content.h"

namespace tellurion::scene {
namespace {

using tiling::Edge;
using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

struct Made {
  SurfaceGrid grid;
  MadeMesh made;
};

GroundSamples samplesOf(const Tiling& tiling, const TileId& id, const ProceduralSource::Height& height,
                        int cells = 64) {
  GroundSamples out(cells + 3, cells + 3, 0.0f);
  for (int row = -1; row <= cells + 1; ++row) {
    for (int col = -1; col <= cells + 1; ++col) {
      const auto place = tiling.wrapped(tiling::rootPointIn(id, double(col) / cells, double(row) / cells));
      if (place) out.at(col + 1, row + 1) = static_cast<float>(height(tiling.direction(*place)));
    }
  }
  return out;
}

Made madeOf(const Tiling& tiling, const TileId& id, const GroundSamples& heights, const TerrainMesh* parent = nullptr) {
  Made out{.grid = surfaceGrid(tiling, kEarth, id, heights), .made = {}};
  out.made = makeTerrainMesh(tiling, kEarth, out.grid, parent);
  return out;
}

/// Triangles of the ranges, as vertex numbers.
std::vector<std::array<std::uint16_t, 3>> trianglesOf(const TerrainMesh& mesh,
                                                      std::initializer_list<IndexRange> ranges) {
  std::vector<std::array<std::uint16_t, 3>> out;
  for (const IndexRange& range : ranges) {
    for (std::uint32_t i = range.first; i < range.first + range.count; i += 3) {
      out.push_back({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
    }
  }
  return out;
}

IndexRange rangeOf(const TerrainMesh& mesh, std::size_t edge, bool coarse) {
  return coarse ? mesh.coarseEdge[edge] : mesh.fineEdge[edge];
}

using Bits = std::array<double, 3>;
/// onParent: when it lies wholly on the parent's surface.
Bits placeOf(const TerrainMesh& mesh, std::uint16_t v, bool onParent = false) {
  const TerrainVertex& vertex = mesh.vertices[v];
  const geo::Vec3 way = geo::Vec3(vertex.toParent[0], vertex.toParent[1], vertex.toParent[2]) *
                        (onParent ? static_cast<double>(mesh.parentStep_m) : 0.0);
  const geo::Vec3 fine(vertex.fine_tile[0], vertex.fine_tile[1], vertex.fine_tile[2]);
  const geo::Vec3 p = mesh.origin.m + geo::Vec3(vertex.position_tile) + fine * vertexGrid_m(kEarth) + way;
  return {p.x, p.y, p.z};
}

/// The positions of the vertices on an edge in body coordinates, in the order along it. The interior may not touch it.
std::vector<Bits> edgeOf(const TerrainMesh& mesh, Edge edge, bool coarse, bool onParent = false) {
  const bool horizontal = edge == Edge::top || edge == Edge::bottom;
  const std::uint16_t line = edge == Edge::top || edge == Edge::left ? 0 : kPlaceUnits;
  std::map<std::uint16_t, Bits> out;
  for (const auto& t : trianglesOf(mesh, {rangeOf(mesh, static_cast<std::size_t>(edge), coarse)})) {
    for (const std::uint16_t v : t) {
      const TerrainVertex& vertex = mesh.vertices[v];
      if ((horizontal ? vertex.t : vertex.s) == line)
        out[horizontal ? vertex.s : vertex.t] = placeOf(mesh, v, onParent);
    }
  }
  std::vector<Bits> places;
  for (const auto& [along, place] : out)
    places.push_back(place);
  return places;
}

class MeshOnTiling : public testing::TestWithParam<Scheme> {
 protected:
  TileId randomTile(std::mt19937_64& random, int maxLevel) const {
    const int level = static_cast<int>(geo::uniform(random, 0.0, maxLevel + 0.999));
    const double across = std::exp2(level);
    const auto pick = [&] {
      const double kind = geo::uniform(random, 0.0, 1.0);
      if (kind < 0.25) return 0u;
      if (kind < 0.5) return static_cast<std::uint32_t>(across - 1.0);
      if (kind < 0.6) return static_cast<std::uint32_t>(across / 2.0);  // at the poles, where those are in the middle
      return static_cast<std::uint32_t>(geo::uniform(random, 0.0, across * 0.9999));
    };
    const auto root = static_cast<std::uint8_t>(geo::uniform(random, 0.0, tiling.rootCount() - 0.001));
    return {static_cast<std::uint8_t>(level), root, pick(), pick()};
  }
  Tiling tiling{GetParam()};
};

INSTANTIATE_TEST_SUITE_P(All, MeshOnTiling, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// From noise that keeps every sample, over hills, to the bare ellipsoid.
double groundOf(int kind, const geo::Direction& d, int level) {
  switch (kind) {
    case 0:
      return std::min(8000.0, 1e7 * tiling::tileSize(level)) * hashOf(d, 1);
    case 1:
      return hashOf(d, 2) < 0.03 ? std::min(5e4, 5e7 * tiling::tileSize(level)) * hashOf(d, 3) : hillsAt(d);
    case 2:
      return hillsAt(d);
    default:
      return 0.0;
  }
}

TEST_P(MeshOnTiling, sharedEdgesAreTheSameToTheLastBit) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 24; ++i) {
    const TileId id = randomTile(random, i < 20 ? 8 : 22);
    const auto height = [&](const geo::Direction& d) { return groundOf(i % 4, d, id.level); };
    const Made mine = madeOf(tiling, id, samplesOf(tiling, id, height));
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling.edgeNeighbour(id, edge);
      const Made other = madeOf(tiling, same.tile, samplesOf(tiling, same.tile, height));
      auto theirs = edgeOf(*other.made.mesh, same.edge, false);
      if (same.reversed) std::reverse(theirs.begin(), theirs.end());
      const auto ours = edgeOf(*mine.made.mesh, edge, false);
      ASSERT_EQ(ours.size(), theirs.size())
          << "edge " << int(edge) << " of " << int(id.level) << "/" << int(id.root) << "/" << id.x << "/" << id.y;
      ASSERT_TRUE(ours == theirs);
      ASSERT_GE(ours.size(), 3u);
    }
  }
}

/// A tile as drawn, with its parent's mesh to morph from.
DrawnTile morphingTile(const Tiling& tiling, const TileId& id, const ProceduralSource::Height& height) {
  const Made parent = madeOf(tiling, id.parent(), samplesOf(tiling, id.parent(), height));
  DrawnTile tile;
  tile.id = id;
  tile.mesh = madeOf(tiling, id, samplesOf(tiling, id, height), parent.made.mesh.get()).made.mesh;
  return tile;
}

/// The point of a mesh with fine edges at a place in twice kPlaceUnits.
std::optional<geo::Vec3> pointAt(const DrawnTile& tile, int s2, int t2, const Frame& frame) {
  const TerrainMesh& mesh = *tile.mesh;
  const auto& fine = mesh.fineEdge;
  for (const auto& t : trianglesOf(mesh, {mesh.interior, fine[0], fine[1], fine[2], fine[3]})) {
    const auto vertex = [&](std::size_t i) -> const TerrainVertex& { return mesh.vertices[t[i]]; };
    const auto doubleAreaWith = [&](std::size_t i, std::size_t j) {
      const std::int64_t x = 2 * vertex(i).s - s2, y = 2 * vertex(i).t - t2;
      return (2 * vertex(j).s - s2) * y - (2 * vertex(j).t - t2) * x;
    };
    const std::array<std::int64_t, 3> w{doubleAreaWith(1, 2), doubleAreaWith(2, 0), doubleAreaWith(0, 1)};
    if (std::min({w[0], w[1], w[2]}) < 0 && std::max({w[0], w[1], w[2]}) > 0) continue;
    geo::Vec3 sum(0.0);
    for (std::size_t i = 0; i < 3; ++i)
      sum += drawnPosition(tile, vertex(i), frame).m * static_cast<double>(w[i]);
    return sum / static_cast<double>(w[0] + w[1] + w[2]);
  }
  return std::nullopt;
}

TEST_P(MeshOnTiling, withoutMorphATileLiesOnItsParentsTriangles) {
  std::mt19937_64 random = geo::seededGenerator();
  int moved = 0;
  for (int i = 0; i < 18; ++i) {
    TileId id = randomTile(random, i < 14 ? 8 : 22);
    if (id.level == 0) id = id.child(i % 4);
    // Noise of half a spacing, hills, the ellipsoid: what 16 bits reach.
    const auto height = [&](const geo::Direction& d) {
      return i % 3 == 0 ? 8e4 * tiling::tileSize(id.level) * hashOf(d, 1) : groundOf(1 + i % 3, d, id.level);
    };
    DrawnTile parent;
    parent.mesh = madeOf(tiling, id.parent(), samplesOf(tiling, id.parent(), height)).made.mesh;
    DrawnTile tile = morphingTile(tiling, id, height);
    tile.morph = {};
    Frame frame;
    frame.vertexGrid_m = vertexGrid_m(kEarth);
    const double slack_m = 2.0 * static_cast<double>(tile.mesh->parentStep_m);
    for (const TerrainVertex& v : tile.mesh->vertices) {
      const auto expected =
          pointAt(parent, v.s + (id.quadrant() & 1) * kPlaceUnits, v.t + (id.quadrant() >> 1) * kPlaceUnits, frame);
      ASSERT_TRUE(expected);
      const geo::Vec3 drawn = drawnPosition(tile, v, frame).m;
      ASSERT_LE(geo::length(drawn - *expected), slack_m) << "at " << v.s << ", " << v.t << " of " << int(id.level)
                                                         << "/" << int(id.root) << "/" << id.x << "/" << id.y;
      DrawnTile own = tile;
      own.morph.fill(1.0f);
      moved += geo::length(drawn - drawnPosition(own, v, frame).m) > slack_m ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 1000);
}

TEST_P(MeshOnTiling, withoutMorphATileIsItsParentsSurfaceBetweenVerticesToo) {
  constexpr int kTiles = 30;
  constexpr int kPlaces = 1000;
  // In strips along the edges of the parent, which are filled as they come, triangles are no parts of its triangles.
  constexpr double kOffShare = 0.06;
  constexpr double kFarOffShare = 0.0025;
  std::mt19937_64 random = geo::seededGenerator();
  int off = 0;
  int farOff = 0;
  for (int i = 0; i < kTiles; ++i) {
    TileId id = randomTile(random, 10);
    if (id.level == 0) id = id.child(i % 4);
    // Rocks of up to two spacings, far enough apart that meshes leave out most samples.
    const auto height = [&](const geo::Direction& d) {
      return hashOf(d, 1) < 0.01 ? 3e5 * tiling::tileSize(id.level) * hashOf(d, 2) : 0.0;
    };
    DrawnTile parent;
    parent.mesh = madeOf(tiling, id.parent(), samplesOf(tiling, id.parent(), height)).made.mesh;
    DrawnTile tile = morphingTile(tiling, id, height);
    tile.morph = {};
    Frame frame;
    frame.vertexGrid_m = vertexGrid_m(kEarth);
    const double tolerance_m = meshTolerance_m(tiling, kEarth, id.level, 64);
    for (int k = 0; k < kPlaces; ++k) {
      const auto s = static_cast<int>(geo::uniform(random, 0.0, kPlaceUnits));
      const auto t = static_cast<int>(geo::uniform(random, 0.0, kPlaceUnits));
      const auto drawn = pointAt(tile, 2 * s, 2 * t, frame);
      const auto expected =
          pointAt(parent, s + (id.quadrant() & 1) * kPlaceUnits, t + (id.quadrant() >> 1) * kPlaceUnits, frame);
      ASSERT_TRUE(drawn && expected);
      const double off_m = geo::length(*drawn - *expected);
      off += off_m > 0.01 * tolerance_m ? 1 : 0;
      farOff += off_m > 0.5 * tolerance_m ? 1 : 0;
    }
  }
  EXPECT_LE(off, kOffShare * kTiles * kPlaces);
  EXPECT_LE(farOff, kFarOffShare * kTiles * kPlaces);
}

/// Where the vertices on an edge are drawn, in the order along it.
std::vector<Bits> drawnEdge(const DrawnTile& tile, Edge edge, const Frame& frame) {
  const bool horizontal = edge == Edge::top || edge == Edge::bottom;
  const std::uint16_t line = edge == Edge::top || edge == Edge::left ? 0 : kPlaceUnits;
  std::map<std::uint16_t, Bits> out;
  for (const auto& t : trianglesOf(*tile.mesh, {tile.mesh->fineEdge[static_cast<std::size_t>(edge)]})) {
    for (const std::uint16_t v : t) {
      const TerrainVertex& vertex = tile.mesh->vertices[v];
      if ((horizontal ? vertex.t : vertex.s) != line) continue;
      const geo::Vec3 p = drawnPosition(tile, vertex, frame).m;
      out[horizontal ? vertex.s : vertex.t] = {p.x, p.y, p.z};
    }
  }
  std::vector<Bits> places;
  for (const auto& [along, place] : out)
    places.push_back(place);
  return places;
}

/// Any number, the same for all tiles that have the corner.
void morphAnyhow(const Tiling& tiling, DrawnTile& tile, std::uint64_t seed) {
  const TileCorners at = tileCorners(tiling, tile.id);
  for (std::size_t q = 0; q < 4; ++q) {
    const auto share = static_cast<double>((at[q] ^ seed) * 0x9e3779b97f4a7c15u >> 32) * 0x1p-32;
    tile.morph[q] = static_cast<float>(share);
  }
}

TEST_P(MeshOnTiling, sharedEdgesMorphToTheSameBits) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 24; ++i) {
    TileId id = randomTile(random, i < 20 ? 8 : 22);
    if (id.level == 0) id = id.child(i % 4);
    const auto height = [&](const geo::Direction& d) { return groundOf(i % 4, d, id.level); };
    DrawnTile mine = morphingTile(tiling, id, height);
    const std::uint64_t seed = random();
    morphAnyhow(tiling, mine, seed);
    Frame frame;
    frame.vertexGrid_m = vertexGrid_m(kEarth);
    frame.exaggeration = i % 2 == 0 ? 1.0 : 3.0;
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling.edgeNeighbour(id, edge);
      if (same.tile.parent() == id.parent()) continue;
      DrawnTile other = morphingTile(tiling, same.tile, height);
      morphAnyhow(tiling, other, seed);
      const auto ours = drawnEdge(mine, edge, frame);
      auto theirs = drawnEdge(other, same.edge, frame);
      if (same.reversed) std::reverse(theirs.begin(), theirs.end());
      ASSERT_TRUE(ours == theirs) << "edge " << int(edge) << " of " << int(id.level) << "/" << int(id.root) << "/"
                                  << id.x << "/" << id.y << ", beyond it " << int(same.tile.level) << "/"
                                  << int(same.tile.root) << "/" << same.tile.x << "/" << same.tile.y;
    }
  }
}

TEST_P(MeshOnTiling, coarseEdgesAreTheCoarserNeighboursToTheLastBit) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 24; ++i) {
    TileId id = randomTile(random, i < 20 ? 8 : 22);
    if (id.level == 0) id = id.child(1);
    const auto height = [&](const geo::Direction& d) { return groundOf(i % 4, d, id.level); };
    const Made mine = madeOf(tiling, id, samplesOf(tiling, id, height));
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling.edgeNeighbour(id, edge);
      const TileId coarser = same.tile.parent();
      if (coarser == id.parent()) continue;
      const Made other = madeOf(tiling, coarser, samplesOf(tiling, coarser, height));
      auto theirs = edgeOf(*other.made.mesh, same.edge, false);
      const auto ours = edgeOf(*mine.made.mesh, edge, true);
      // Ours is one half of theirs, which always has its middle.
      if (same.reversed) std::reverse(theirs.begin(), theirs.end());
      const auto first = std::search(theirs.begin(), theirs.end(), ours.begin(), ours.end());
      ASSERT_NE(first, theirs.end()) << "edge " << int(edge) << " of " << int(id.level) << "/" << int(id.root) << "/"
                                     << id.x << "/" << id.y;
      ASSERT_TRUE(ours.front() == theirs.front() || ours.back() == theirs.back());
    }
  }
}

TEST_P(MeshOnTiling, coarseEdgesAreTheCoarserNeighboursWhereLevelsDisagree) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 24; ++i) {
    TileId id = randomTile(random, i < 20 ? 8 : 22);
    if (id.level < 2) id = id.child(1).child(2);
    const auto heightOn = [&](int level) {
      return [&, level](const geo::Direction& d) {
        return groundOf(i % 4, d, 2) + 900.0 * hashOf(d, 17u + static_cast<unsigned>(level));
      };
    };
    const auto made = [&](const TileId& tile, const TerrainMesh* parent) {
      return madeOf(tiling, tile, samplesOf(tiling, tile, heightOn(tile.level)), parent).made.mesh;
    };
    const auto withParent = [&](const TileId& tile) { return made(tile, made(tile.parent(), nullptr).get()); };
    const auto mine = made(id, withParent(id.parent()).get());
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling.edgeNeighbour(id, edge);
      if (same.tile.parent() == id.parent()) continue;
      auto theirs = edgeOf(*withParent(same.tile.parent()), same.edge, false);
      const auto ours = edgeOf(*mine, edge, true, true);
      if (same.reversed) std::reverse(theirs.begin(), theirs.end());
      ASSERT_NE(std::search(theirs.begin(), theirs.end(), ours.begin(), ours.end()), theirs.end())
          << "edge " << int(edge) << " of " << int(id.level) << "/" << int(id.root) << "/" << id.x << "/" << id.y;
    }
  }
}

TEST_P(MeshOnTiling, everyChoiceOfEdgesCoversTheSquareOnceAndFacesOutwards) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 12; ++i) {
    const TileId id = randomTile(random, 10);
    const Made m = madeOf(tiling, id,
                          samplesOf(tiling, id, [&](const geo::Direction& d) { return groundOf(i % 4, d, id.level); }));
    const TerrainMesh& mesh = *m.made.mesh;
    for (unsigned mask = 0; mask < 16; ++mask) {
      auto triangles = trianglesOf(mesh, {mesh.interior});
      for (std::size_t e = 0; e < 4; ++e) {
        const auto strip = trianglesOf(mesh, {rangeOf(mesh, e, ((mask >> e) & 1u) != 0)});
        triangles.insert(triangles.end(), strip.begin(), strip.end());
      }
      std::int64_t area = 0;
      for (const auto& t : triangles) {
        const auto point = [&](int k) {
          const TerrainVertex& v = mesh.vertices[t[static_cast<std::size_t>(k)]];
          return GridPoint{static_cast<std::int16_t>(std::lround(v.s * 64.0 / static_cast<double>(kPlaceUnits))),
                           static_cast<std::int16_t>(std::lround(v.t * 64.0 / static_cast<double>(kPlaceUnits)))};
        };
        const int doubled = doubleArea(point(0), point(1), point(2));
        ASSERT_GT(doubled, 0);  // counter-clockwise in the square, so none overlaps if the areas add up
        area += doubled;
      }
      ASSERT_EQ(area, 2 * 64 * 64);
    }
  }
}

TEST_P(MeshOnTiling, trianglesAreCounterClockwiseFromOutsideAndNoSlivers) {
  std::mt19937_64 random = geo::seededGenerator();
  double flattest = 1.0;
  for (int i = 0; i < 60; ++i) {
    const TileId id = randomTile(random, 10);
    const Made m = madeOf(tiling, id,
                          samplesOf(
                              tiling, id, i % 2 == 0 ? hillsAt : [](const geo::Direction&) { return 0.0; }));
    const TerrainMesh& mesh = *m.made.mesh;
    for (const auto& t : trianglesOf(
             mesh, {mesh.interior, mesh.fineEdge[0], mesh.coarseEdge[1], mesh.fineEdge[2], mesh.coarseEdge[3]})) {
      const auto corner = [&](std::size_t k) { return geo::Vec3(mesh.vertices[t[k]].position_tile); };
      const geo::Vec3 a = corner(1) - corner(0);
      const geo::Vec3 b = corner(2) - corner(0);
      const geo::Vec3 c = corner(2) - corner(1);
      const double area = geo::dot(geo::cross(a, b), geo::normalize(mesh.origin.m + corner(0)));
      flattest = std::min(flattest, area / std::max({geo::dot(a, a), geo::dot(b, b), geo::dot(c, c)}));
      ASSERT_GT(area, 0.0) << int(id.level) << "/" << int(id.root) << "/" << id.x << "/" << id.y;
    }
  }
  std::printf("height of the flattest triangle: %.3f of its longest side\n", flattest);
  EXPECT_GT(flattest, GetParam() == Scheme::healpix ? 0.001 : 0.1);  // HEALPix squeezes its roots at the poles
}

/// The bilinear ground of a tile, displaced from the ellipsoid, at a place in cells.
geo::Vec3 groundAt(const Tiling& tiling, const TileId& id, const GroundSamples& heights, double col, double row) {
  const double h = heightIn(heights, col / 64.0, row / 64.0);
  return kEarth.bodyFromDirection(tiling.direction(tiling::rootPointIn(id, col / 64.0, row / 64.0)), h).m;
}

double distanceToTriangle(const geo::Vec3& p, const geo::Vec3& a, const geo::Vec3& b, const geo::Vec3& c) {
  const auto toSide = [&](const geo::Vec3& from, const geo::Vec3& to) {
    const geo::Vec3 side = to - from;
    const double share = std::clamp(geo::dot(p - from, side) / geo::dot(side, side), 0.0, 1.0);
    return geo::length(p - (from + side * share));
  };
  const geo::Vec3 normal = geo::cross(b - a, c - a);
  const auto inside = [&](const geo::Vec3& from, const geo::Vec3& to) {
    return geo::dot(geo::cross(to - from, p - from), normal) >= 0.0;
  };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(geo::dot(p - a, geo::normalize(normal)));
  return std::min({toSide(a, b), toSide(b, c), toSide(c, a)});
}

/// From a point to the ground over the cells from (west, north) to (east, south), in triangles of eighths of a cell.
double distanceToGround(const Tiling& tiling, const TileId& id, const GroundSamples& heights, const geo::Vec3& p,
                        const std::array<int, 4>& cells) {
  const auto [west, north, east, south] = cells;
  double nearest = std::numeric_limits<double>::infinity();
  const auto at = [&](int c, int r) { return groundAt(tiling, id, heights, c / 8.0, r / 8.0); };
  for (int r = 8 * north; r < 8 * south; ++r) {
    for (int c = 8 * west; c < 8 * east; ++c) {
      nearest = std::min({nearest, distanceToTriangle(p, at(c, r), at(c + 1, r), at(c, r + 1)),
                          distanceToTriangle(p, at(c + 1, r), at(c + 1, r + 1), at(c, r + 1))});
    }
  }
  return nearest;
}

/// How far random points of random triangles are from the ground: from the ground at the same place, unless it is
/// nearer elsewhere under the triangle.
double worstMiss(const Tiling& tiling, const TileId& id, const GroundSamples& heights, const MadeMesh& made,
                 std::mt19937_64& random) {
  const TerrainMesh& mesh = *made.mesh;
  const auto triangles =
      trianglesOf(mesh, {mesh.interior, mesh.fineEdge[0], mesh.fineEdge[1], mesh.fineEdge[2], mesh.fineEdge[3]});
  const auto inCells = [](std::uint16_t place) { return std::round(place * 64.0 / kPlaceUnits); };
  double worst = 0.0;
  for (int k = 0; k < 3000; ++k) {
    const auto& t = triangles[static_cast<std::size_t>(geo::uniform(random, 0.0, double(triangles.size()) - 0.001))];
    double w0 = geo::uniform(random, 0.0, 1.0);
    double w1 = geo::uniform(random, 0.0, 1.0);
    if (w0 + w1 > 1.0) w0 = 1.0 - w0, w1 = 1.0 - w1;
    const std::array<double, 3> w{w0, w1, 1.0 - w0 - w1};
    geo::Vec3 drawn = mesh.origin.m;
    double col = 0.0;
    double row = 0.0;
    std::array<int, 4> cells{64, 64, 0, 0};
    for (std::size_t c = 0; c < 3; ++c) {
      const TerrainVertex& vertex = mesh.vertices[t[c]];
      drawn += geo::Vec3(vertex.position_tile) * w[c];
      col += w[c] * inCells(vertex.s);
      row += w[c] * inCells(vertex.t);
      cells = {std::min(cells[0], int(inCells(vertex.s))), std::min(cells[1], int(inCells(vertex.t))),
               std::max(cells[2], int(inCells(vertex.s))), std::max(cells[3], int(inCells(vertex.t)))};
    }
    double miss = geo::length(groundAt(tiling, id, heights, col, row) - drawn);
    if (miss > made.error_m) miss = std::min(miss, distanceToGround(tiling, id, heights, drawn, cells));
    worst = std::max(worst, miss);
  }
  return worst;
}

/// The mesh's triangles with the cells that they cover, to ask what is drawn at a place.
struct DrawnTriangle {
  std::array<geo::Vec3, 3> corners;
  std::array<geo::Vec2, 3> cells;
};

std::vector<DrawnTriangle> drawnTrianglesOf(const TerrainMesh& mesh) {
  std::vector<DrawnTriangle> drawn;
  for (const auto& t :
       trianglesOf(mesh, {mesh.interior, mesh.fineEdge[0], mesh.fineEdge[1], mesh.fineEdge[2], mesh.fineEdge[3]})) {
    DrawnTriangle& triangle = drawn.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      const TerrainVertex& vertex = mesh.vertices[t[c]];
      triangle.corners[c] = mesh.origin.m + geo::Vec3(vertex.position_tile);
      triangle.cells[c] = geo::Vec2(vertex.s, vertex.t) * (64.0 / kPlaceUnits);
    }
  }
  return drawn;
}

/// The point of a triangle that is nearest to a point.
double distanceTo(const std::array<geo::Vec3, 3>& t, const geo::Vec3& p) {
  const geo::Vec3 normal = geo::cross(t[1] - t[0], t[2] - t[0]);
  const double area2 = geo::dot(normal, normal);
  bool isOver = area2 > 0.0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < 3; ++c) {
    const geo::Vec3 side = t[(c + 1) % 3] - t[c];
    isOver = isOver && geo::dot(geo::cross(side, p - t[c]), normal) >= 0.0;
    const double length2 = geo::dot(side, side);
    const double share = length2 > 0.0 ? std::clamp(geo::dot(p - t[c], side) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, geo::length(t[c] + side * share - p));
  }
  return isOver ? std::abs(geo::dot(p - t[0], normal)) / std::sqrt(area2) : nearest;
}

double cross2(const geo::Vec2& a, const geo::Vec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// The other way round: how far the ground at random places, samples or anywhere between them, is from the mesh: from
/// what is drawn at the place, unless some triangle is nearer.
double worstLeftOut(const Tiling& tiling, const TileId& id, const GroundSamples& heights, const MadeMesh& made,
                    std::mt19937_64& random) {
  constexpr int kPlaces = 1000;
  const std::vector<DrawnTriangle> drawn = drawnTrianglesOf(*made.mesh);
  double worst = 0.0;
  for (int k = 0; k < kPlaces; ++k) {
    geo::Vec2 at(geo::uniform(random, 0.0, 64.0), geo::uniform(random, 0.0, 64.0));
    if (k % 4 == 0) at = {std::round(at.x), std::round(at.y)};
    const geo::Vec3 ground = groundAt(tiling, id, heights, at.x, at.y);
    double miss = std::numeric_limits<double>::infinity();
    for (const DrawnTriangle& t : drawn) {
      const double area = cross2(t.cells[1] - t.cells[0], t.cells[2] - t.cells[0]);
      const std::array<double, 3> w{cross2(t.cells[1] - at, t.cells[2] - at) / area,
                                    cross2(t.cells[2] - at, t.cells[0] - at) / area,
                                    cross2(t.cells[0] - at, t.cells[1] - at) / area};
      if (std::min({w[0], w[1], w[2]}) < -1e-9) continue;
      miss = std::min(miss, geo::length(t.corners[0] * w[0] + t.corners[1] * w[1] + t.corners[2] * w[2] - ground));
    }
    EXPECT_LT(miss, std::numeric_limits<double>::infinity()) << "nothing is drawn at " << at.x << ", " << at.y;
    for (std::size_t i = 0; miss > made.error_m && i < drawn.size(); ++i)
      miss = std::min(miss, distanceTo(drawn[i].corners, ground));
    worst = std::max(worst, miss);
  }
  return worst;
}

TEST_P(MeshOnTiling, theErrorHoldsEverywhere) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 8; ++i) {
    const TileId id = randomTile(random, 7);
    const GroundSamples heights =
        samplesOf(tiling, id, [&](const geo::Direction& d) { return groundOf(i % 4, d, id.level); });
    const Made m = madeOf(tiling, id, heights);
    EXPECT_LE(worstMiss(tiling, id, heights, m.made, random), m.made.error_m * 1.001 + 1e-3) << i;
    const double leftOut_m = worstLeftOut(tiling, id, heights, m.made, random);
    EXPECT_LE(leftOut_m, m.made.error_m * 1.001 + 1e-3) << i;
    EXPECT_LT(m.made.error_m, 5e5);
    EXPECT_GT(leftOut_m, 0.01 * m.made.error_m) << i;
  }
}

TEST_P(MeshOnTiling, theErrorOfACliffIsItsWidth) {
  std::mt19937_64 random = geo::seededGenerator();
  constexpr double kHeight_m = 2500.0;
  for (int i = 0; i < 4; ++i) {
    const TileId id{.level = 12, .root = 4, .x = 1500u + 300u * static_cast<unsigned>(i), .y = 2100};
    // A step between two samples, in stairs: what the border of a model looks like on a map that runs aslant to it.
    GroundSamples heights(67, 67, 0.0f);
    for (int row = 0; row < 67; ++row) {
      for (int col = 0; col < 67; ++col)
        heights.at(col, row) = col + i * row > 33 + i * 25 ? static_cast<float>(kHeight_m) : 0.0f;
    }
    const Made m = madeOf(tiling, id, heights);
    const double spacing_m = tiling.metrics(id.level).largestEdge.radians() * kEarth.semiMajorAxis_m() / 64.0;
    EXPECT_LE(m.made.error_m, 3.0 * spacing_m) << i;
    EXPECT_LE(worstMiss(tiling, id, heights, m.made, random), m.made.error_m * 1.001 + 1e-3) << i;
    const double leftOut_m = worstLeftOut(tiling, id, heights, m.made, random);
    EXPECT_LE(leftOut_m, m.made.error_m * 1.001 + 1e-3) << i;
  }
}

TEST_P(MeshOnTiling, theBoxHoldsTheGround) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 10; ++i) {
    const TileId id = randomTile(random, 12);
    const GroundSamples heights = samplesOf(tiling, id, hillsAt);
    const Made m = madeOf(tiling, id, heights);
    for (int k = 0; k < 500; ++k) {
      const double s = geo::uniform(random, 0.0, 1.0);
      const double t = geo::uniform(random, 0.0, 1.0);
      const int col = std::min(static_cast<int>(s * 64.0), 63);
      const int row = std::min(static_cast<int>(t * 64.0), 63);
      const auto at = [&](int dc, int dr) { return double(heights.at(col + dc + 1, row + dr + 1)); };
      const double x = s * 64.0 - col;
      const double y = t * 64.0 - row;
      const double h = (at(0, 0) * (1 - x) + at(1, 0) * x) * (1 - y) + (at(0, 1) * (1 - x) + at(1, 1) * x) * y;
      EXPECT_TRUE(
          m.made.box.contains(kEarth.bodyFromDirection(tiling.direction(tiling::rootPointIn(id, s, t)), h), 1e-6));
    }
  }
}

TEST_P(MeshOnTiling, fewTrianglesWhereTheGroundIsFlat) {
  const TileId id{.level = 6, .root = 0, .x = 20, .y = 33};
  const Made flat = madeOf(tiling, id, samplesOf(tiling, id, [](const geo::Direction&) { return 0.0; }));
  EXPECT_LE(trianglesOf(*flat.made.mesh, {flat.made.mesh->interior, flat.made.mesh->fineEdge[0]}).size(), 16u);
  const Made rough =
      madeOf(tiling, id, samplesOf(tiling, id, [](const geo::Direction& d) { return groundOf(0, d, 6); }));
  EXPECT_GT(rough.made.mesh->indices.size(), flat.made.mesh->indices.size());
}

TEST_P(MeshOnTiling, theRegularMeshKeepsEverySample) {
  std::mt19937_64 random = geo::seededGenerator();
  for (const int cells : {4, 64, 128}) {
    const TileId id = randomTile(random, 10);
    const SurfaceGrid grid = surfaceGrid(tiling, kEarth, id, samplesOf(tiling, id, hillsAt, cells));
    const MadeMesh made = makeTerrainMesh(tiling, kEarth, grid, nullptr, true);
    const TerrainMesh& mesh = *made.mesh;
    const auto trianglesWith = [&](unsigned coarse) {
      std::size_t count = mesh.interior.count;
      for (std::size_t e = 0; e < 4; ++e)
        count += rangeOf(mesh, e, ((coarse >> e) & 1u) != 0).count;
      return static_cast<int>(count / 3);
    };
    EXPECT_EQ(trianglesWith(0), 2 * cells * cells);
    EXPECT_EQ(trianglesWith(15), 2 * cells * cells - 4 * cells / 2);  // a vertex less on an edge is a triangle less
    EXPECT_EQ(mesh.vertices.size(), static_cast<std::size_t>((cells + 1) * (cells + 1)));
    EXPECT_LE(made.error_m, makeTerrainMesh(tiling, kEarth, grid).error_m);
  }
}

TEST_P(MeshOnTiling, verticesAreTheRoundedGroundAtEveryLevel) {
  std::mt19937_64 random = geo::seededGenerator();
  for (const int level : {0, 1, 5, 14, 26}) {
    const geo::Direction d = geo::directionFromDegrees(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180));
    const TileId id = tiling.tileAt(d, level);
    const Made m = madeOf(tiling, id, samplesOf(tiling, id, hillsAt));
    const TerrainMesh& mesh = *m.made.mesh;
    for (std::uint16_t v = 0; v < mesh.vertices.size(); ++v) {
      const int col = static_cast<int>(std::lround(mesh.vertices[v].s * 64.0 / static_cast<double>(kPlaceUnits)));
      const int row = static_cast<int>(std::lround(mesh.vertices[v].t * 64.0 / static_cast<double>(kPlaceUnits)));
      const geo::Vec3 truth = m.grid.positions[m.grid.index(col, row)].m;
      const Bits place = placeOf(mesh, v);
      for (int axis = 0; axis < 3; ++axis) {
        const double steps = place[static_cast<std::size_t>(axis)] / vertexGrid_m(kEarth);
        ASSERT_EQ(steps, std::round(steps));
        ASSERT_NEAR(place[static_cast<std::size_t>(axis)], truth[axis], vertexGrid_m(kEarth) / 2);
      }
    }
  }
}

TEST_P(MeshOnTiling, reliefAgreesAlongEdges) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 12; ++i) {
    const TileId id = randomTile(random, 6);
    const auto picture = [&](const TileId& t) {
      return makeRelief(surfaceGrid(tiling, kEarth, t, samplesOf(tiling, t, hillsAt)))->mips[0];
    };
    const auto mine = picture(id);
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling.edgeNeighbour(id, edge);
      const auto theirs = picture(same.tile);
      for (int k = 0; k <= 64; ++k) {
        const GridPoint here = edgePoint(static_cast<int>(edge), k, 64);
        const GridPoint there = edgePoint(static_cast<int>(same.edge), same.reversed ? 64 - k : k, 64);
        const auto a = mine.at(here.col, here.row);
        const auto b = theirs.at(there.col, there.row);
        ASSERT_LE(std::abs(a.r - b.r) + std::abs(a.g - b.g) + std::abs(a.b - b.b), 2)
            << "sample " << k << " of edge " << int(edge);
      }
    }
  }
}

TEST_P(MeshOnTiling, reliefIsTheSlope) {
  // A plane that rises to the east by one in ten near latitude 20, longitude 30.
  const geo::Direction centre = geo::directionFromDegrees(20.0, 30.0);
  const geo::Vec3 east = geo::normalize(geo::cross(geo::Vec3(0, 0, 1), centre.n));
  const TileId id = tiling.tileAt(centre, 9);
  const auto height = [&](const geo::Direction& d) { return 0.1 * 6.378e6 * geo::dot(d.n, east); };
  const auto picture = makeRelief(surfaceGrid(tiling, kEarth, id, samplesOf(tiling, id, height)))->mips[0];
  const geo::Vec3 up = tiling.direction(tiling::rootPointIn(id, 0.5, 0.5)).n;
  const geo::Vec3 expected = geo::normalize(up - east * 0.1) - up;
  const auto texel = picture.at(32, 32);
  EXPECT_NEAR((texel.r - 128) / 127.0, expected.x, 0.01);
  EXPECT_NEAR((texel.g - 128) / 127.0, expected.y, 0.01);
  EXPECT_NEAR((texel.b - 128) / 127.0, expected.z, 0.01);
}

/// Meshes of the tiles of one ground, each made once.
class Meshes {
 public:
  Meshes(const Tiling& tiling, std::vector<std::shared_ptr<ProceduralSource>> sources,
         std::uint32_t roots = GroundLayers::kAllRoots)
      : tiling_(tiling), ground_(tiling, layersOf(sources, roots), 64) {}

  const TerrainMesh& of(const TileId& id) {
    const auto [found, isNew] = made_.try_emplace(id);
    if (isNew) found->second = madeOf(tiling_, id, ground_.compose(id).heights);
    return *found->second.made.mesh;
  }

  /// Both sides of all edges of a tile have the same vertices, and the coarse ones are its parents'.
  void expectSameEdges(const TileId& id) {
    for (const Edge edge : tiling::kEdges) {
      const auto same = tiling_.edgeNeighbour(id, edge);
      auto theirs = edgeOf(of(same.tile), same.edge, false);
      if (same.reversed) std::reverse(theirs.begin(), theirs.end());
      const auto ours = edgeOf(of(id), edge, false);
      ASSERT_TRUE(ours == theirs);
      if (same.tile.parent() == id.parent()) continue;
      auto coarser = edgeOf(of(same.tile.parent()), same.edge, false);
      if (same.reversed) std::reverse(coarser.begin(), coarser.end());
      const auto half = edgeOf(of(id), edge, true);
      ASSERT_NE(std::search(coarser.begin(), coarser.end(), half.begin(), half.end()), coarser.end());
    }
  }

 private:
  /// roots: of the last.
  static std::vector<GroundLayers::Layer> layersOf(const std::vector<std::shared_ptr<ProceduralSource>>& sources,
                                                   std::uint32_t roots) {
    std::vector<GroundLayers::Layer> layers;
    for (const auto& source : sources)
      layers.emplace_back(
          std::make_shared<LayerTiles>(source, std::uint64_t{64} << 20, std::make_shared<LoadLedger>()));
    layers.back().roots = roots;
    return layers;
  }

  Tiling tiling_;
  GroundLayers ground_;
  std::map<TileId, Made> made_;
};

/// A place on an edge that its two tiles run along in opposite senses; anywhere where the tiling has none.
geo::Direction reversedPlace(const Tiling& tiling, std::mt19937_64& random) {
  for (int i = 0; i < 400; ++i) {
    const auto along = static_cast<std::uint32_t>(geo::uniform(random, 4, 28));
    const TileId id{.level = 5,
                    .root = static_cast<std::uint8_t>(geo::uniform(random, 0, tiling.rootCount())),
                    .x = i % 2 == 0 ? along : 31,
                    .y = i % 2 == 0 ? 31 : along};
    const Edge edge = i % 2 == 0 ? Edge::bottom : Edge::right;
    if (!tiling.edgeNeighbour(id, edge).reversed) continue;
    return tiling.direction(tiling::rootPointIn(id, i % 2 == 0 ? 0.4 : 1.0, i % 2 == 0 ? 1.0 : 0.4));
  }
  return geo::directionFromDegrees(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180));
}

std::shared_ptr<ProceduralSource> patchyLayer(Scheme scheme, int depth, double gaps, std::uint64_t seed) {
  auto source = std::make_shared<ProceduralSource>(raster::Kind::elevation, scheme, depth);
  source->height = [=](const geo::Direction& d) {
    return hashOf(d, seed) < gaps ? std::nan("") : 5000.0 * hashOf(d, seed + 1);
  };
  return source;
}

TileId tileNear(const Tiling& tiling, const geo::Direction& middle, double spread, int level, std::mt19937_64& random) {
  const geo::Vec3 aside(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
  return tiling.tileAt({geo::normalize(middle.n + aside * spread)}, level);
}

/// Stored only near one place below level 3: neighbours at all differences of depth.
TEST_P(MeshOnTiling, sparseDataStillGivesTheSameEdges) {
  std::mt19937_64 random = geo::seededGenerator();
  const geo::Direction anywhere =
      geo::directionFromDegrees(geo::uniform(random, -90, 90), geo::uniform(random, -180, 180));
  for (const geo::Direction& middle : {anywhere, reversedPlace(tiling, random)}) {
    const auto source = patchyLayer(GetParam(), 7, 0.25, 9);
    source->stored = [&](const TileId& id) {
      if (id.level <= 3) return true;
      const auto cap = tiling.cap(id);
      return geo::angleBetween(cap.centre, middle).radians() < cap.radius.radians() + 0.02;
    };
    Meshes meshes(tiling, {source});
    int stored = 0;
    for (int i = 0; i < 40; ++i) {
      const TileId id = tileNear(tiling, middle, 0.04, 4 + i % 5, random);
      stored += source->stored(id) ? 1 : 0;
      ASSERT_NO_FATAL_FAILURE(meshes.expectSameEdges(id));
    }
    EXPECT_GT(stored, 5);
    for (const auto& [id, count] : source->requests())
      EXPECT_EQ(count, 1);
  }
}

/// Through the gaps of a deep layer one shows that is not stored as deep, and has gaps too. At half of its samples two
/// are equally near, and tiles that run along their edge in opposite senses must not choose differently.
TEST_P(MeshOnTiling, layersOfDifferentDepthGiveTheSameEdges) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int round = 0; round < 4; ++round) {
    const geo::Direction middle = reversedPlace(tiling, random);
    Meshes meshes(tiling, {patchyLayer(GetParam(), 5, 0.3, 20), patchyLayer(GetParam(), 7, 0.6, 30)});
    for (int i = 0; i < 8; ++i)
      ASSERT_NO_FATAL_FAILURE(meshes.expectSameEdges(tileNear(tiling, middle, 0.0005, 5 + i % 4, random)));
  }
}

/// Of a server's layer some roots are here and some are not: alone, and over a coarser layer that has all.
TEST_P(MeshOnTiling, aLayerOfSomeRootsGivesTheSameEdges) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int round = 0; round < 8; ++round) {
    const auto roots = static_cast<std::uint32_t>(random()) & ((1u << tiling.rootCount()) - 1u);
    std::vector sources{patchyLayer(GetParam(), 6, 0.1, 60)};
    if (round % 2 == 1) sources.insert(sources.begin(), patchyLayer(GetParam(), 3, 0.1, 50));
    Meshes meshes(tiling, sources, roots);
    for (int i = 0; i < 12; ++i) {
      // On the edge of a root, at a corner every other time.
      const int level = 1 + i % 6;
      const std::uint32_t last = (1u << level) - 1u;
      const auto root = static_cast<std::uint8_t>(geo::uniform(random, 0, tiling.rootCount()));
      const auto along = i % 2 == 0 ? 0u : static_cast<std::uint32_t>(random()) & last;
      ASSERT_NO_FATAL_FAILURE(meshes.expectSameEdges({static_cast<std::uint8_t>(level), root, along, last}));
    }
    for (const auto& [id, count] : sources.back()->requests())
      EXPECT_TRUE(((roots >> id.root) & 1u) != 0) << "asked for what is not here";
  }
}

/// Below the deepest data the ground of the border of the data is the same at every level.
TEST_P(MeshOnTiling, theBorderOfTheDataIsASlopeThatNoLevelChanges) {
  const auto source = patchyLayer(GetParam(), 5, 0.3, 40);
  const GroundLayers ground(
      tiling, {std::make_shared<LayerTiles>(source, std::uint64_t{64} << 20, std::make_shared<LoadLedger>())}, 64);
  const TileId id = tiling.tileAt(geo::directionFromDegrees(33, 44), 5);
  const ComposedGround stored = ground.compose(id);
  for (const int level : {6, 7, 9}) {
    const TileId deep = tiling.tileAt(tiling.direction(tiling::rootPointIn(id, 0.3, 0.6)), level);
    const ComposedGround composed = ground.compose(deep);
    EXPECT_EQ(composed.level, 5);
    EXPECT_EQ(composed.error_m, 0.0);
    const double size = tiling::tileSize(level - 5);
    const double s0 = (deep.x & ((1u << (level - 5)) - 1)) * size;
    const double t0 = (deep.y & ((1u << (level - 5)) - 1)) * size;
    for (int row = 0; row <= 64; row += 3) {
      for (int col = 0; col <= 64; col += 3) {
        ASSERT_NEAR(composed.heights.at(col + 1, row + 1),
                    heightIn(stored.heights, s0 + size * col / 64, t0 + size * row / 64), 0.01);
      }
    }
  }
}

/// From a point over a place of a tile to its surface, tried on a lattice of an eighth of a cell around it: brute
/// force.
double offInSpace(const GroundSamples& surface, double s, double t, double spacing_m, double height_m) {
  const double upwards = std::abs(height_m - heightIn(surface, s, t));
  double least = upwards;
  constexpr int kSteps = 24;
  for (int row = -kSteps; row <= kSteps && upwards > 0.0; ++row) {
    for (int col = -kSteps; col <= kSteps; ++col) {
      const double aside = std::hypot(col, row) / 8.0;
      if (aside * spacing_m >= least) continue;
      const double there =
          heightIn(surface, std::clamp(s + col / 512.0, 0.0, 1.0), std::clamp(t + row / 512.0, 0.0, 1.0));
      least = std::min(least, std::hypot(aside * spacing_m, height_m - there));
    }
  }
  return least;
}

/// A lone plateau, its antipodes at sea level, one on a layer of sea floor, and one with a seam to that: what a coarse
/// tile draws is off by no more than it says, and its box holds all that comes below.
TEST_P(MeshOnTiling, errorsHoldWhereDataEnd) {
  std::mt19937_64 random = geo::seededGenerator();
  const double lat = geo::uniform(random, -80, 80);
  const double lon = geo::uniform(random, -180, 180);
  const geo::Direction middle = geo::directionFromDegrees(lat, lon);
  const auto plateau = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 8);
  plateau->height = [&](const geo::Direction& d) {
    const double angle = geo::angleBetween(d, middle).degrees();
    return angle < 1.0 ? 4000.0 : angle > 175.0 ? 0.0 : std::nan("");
  };
  plateau->heightBound_m = 0.0;  // the plateau's own error: it is flat
  const auto floor = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), 5);
  floor->height = [](const geo::Direction&) { return -3000.0; };
  floor->heightBound_m = 0.0;
  const auto tiles = [](const auto& source) {
    return std::make_shared<LayerTiles>(source, std::uint64_t{64} << 20, std::make_shared<LoadLedger>());
  };
  const double half = 1.1 / std::cos((std::abs(lat) + 1.1) * geo::kPi / 180.0);
  for (const auto& [onFloor, seam_m] : {std::pair(false, 0.0), std::pair(true, 0.0), std::pair(true, 30e3)}) {
    plateau->setBounds(onFloor ? geo::GeoRect::fromDegrees(lat - 1.1, lon - half, lat + 1.1, lon + half)
                               : geo::GeoRect::whole());
    std::vector<GroundLayers::Layer> layers;
    if (onFloor) layers.emplace_back(tiles(floor));
    layers.emplace_back(tiles(plateau), seam_m);
    const ContentMaker maker{.tiling = tiling,
                             .ellipsoid = kEarth,
                             .ground = GroundLayers(tiling, std::move(layers), 64),
                             .colours = ColourLayers({})};
    double worst = 0.0;
    for (int i = 0; i < 40; ++i) {
      const geo::Direction edge = geo::Direction{geo::normalize(
          middle.n + 0.0175 * geo::normalize(geo::cross(middle.n, geo::Vec3(geo::uniform(random, -1, 1),
                                                                            geo::uniform(random, -1, 1), 0.3))))};
      const TileId id = tiling.tileAt(edge, 3 + i % 5);
      const auto coarse = maker.make(id, nullptr);
      const TileId below = tiling.tileAt(edge, 8);
      const auto fine = maker.make(below, nullptr);
      const double size = tiling::tileSize(8 - id.level);
      const std::uint32_t within = (1u << (8 - id.level)) - 1;
      const double spacing_m = tiling.metrics(id.level).largestEdge.radians() / 64 * kEarth.semiMajorAxis_m();
      for (int k = 0; k <= 64 * 64; ++k) {
        const double s = (k % 65) / 64.0;
        const double t = (k / 65) / 64.0;
        const double off = offInSpace(coarse->heights, ((below.x & within) + s) * size, ((below.y & within) + t) * size,
                                      spacing_m, heightIn(fine->heights, s, t));
        ASSERT_LE(off, coarse->error_m + 0.1 * spacing_m);
        worst = std::max(worst, off);
      }
      ASSERT_LE(coarse->range.low_m, fine->range.low_m);
      ASSERT_GE(coarse->range.high_m, fine->range.high_m);
      ASSERT_LE(coarse->box.distance_m({fine->mesh->origin.m}), 0.001);
    }
    EXPECT_GE(worst, onFloor && seam_m == 0.0 ? 100.0 : 0.0);
  }
}

/// The geographic tiling's caps are folded along their diagonals, and so are the meshes of the tiles there.
TEST(TerrainMesh, aCreaseOfTheMapIsNoError) {
  const Tiling tiling(Scheme::geographic);
  for (std::uint8_t level = 2; level <= 12; ++level) {
    const std::uint32_t last = (1u << level) - 1;
    for (const TileId& id : {TileId{level, 4, 0, 0}, TileId{level, 4, last, 0}, TileId{level, 5, last / 3, last / 3}}) {
      const Made m = madeOf(tiling, id, samplesOf(tiling, id, [](const geo::Direction&) { return 0.0; }));
      EXPECT_LT(m.made.error_m, 1.15 * meshTolerance_m(tiling, kEarth, level, 64)) << int(level) << "/" << id.x;
    }
  }
}

TEST(TerrainMesh, deepestLevelStaysExact) {
  const Tiling tiling(Scheme::cube);
  const TileId id = tiling.tileAt(geo::directionFromDegrees(27.9881, 86.9250), 26);
  const Made m = madeOf(tiling, id, samplesOf(tiling, id, [](const geo::Direction&) { return 8848.0; }));
  const TerrainMesh& mesh = *m.made.mesh;
  for (const TerrainVertex& v : mesh.vertices) {
    const geo::Vec3 p = mesh.origin.m + geo::Vec3(v.position_tile);
    EXPECT_NEAR(kEarth.geodeticFromBody({p}).height_m, 8848.0, 1e-3);
  }
  EXPECT_LT(m.made.error_m, 1e-4);
}

}  // namespace
}  // namespace tellurion::scene
