#include "scene/terrain_mesh.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "scene/bisection.h"
#include "scene/mesh_error.h"
#include "scene/parent_surface.h"

namespace tellurion::scene {
namespace {

constexpr double kOriginGrid_m = 0x1p-10;
constexpr std::uint16_t kNoVertex = std::numeric_limits<std::uint16_t>::max();

double meanEdge_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level) {
  // One level above the roots is asked for by the coarse edges of the roots' meshes, which are never drawn.
  const double size = tiling.metrics(std::max(level, 0)).meanEdge.radians() * ellipsoid.semiMajorAxis_m();
  return level < 0 ? 2.0 * size : size;
}

geo::Vec3 rounded(const geo::Vec3& p, double grid_m) {
  return geo::Vec3(std::round(p.x / grid_m), std::round(p.y / grid_m), std::round(p.z / grid_m)) * grid_m;
}

/// The unit of TerrainVertex::toParent: 16 bits reach four to eight spacings of the level's samples, far more than two
/// meshes within their tolerances are apart.
double parentStep_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level, int cells) {
  return std::exp2(std::ceil(std::log2(meanEdge_m(tiling, ellipsoid, level) / cells)) - 13.0);
}

using EdgeFlags = std::array<std::vector<std::uint8_t>, 4>;

/// Which samples of the edges are vertices, of every step-th.
EdgeFlags flagsOfEdges(const SurfaceGrid& grid, int step, double tolerance_m, bool keepMiddle) {
  EdgeFlags flags;
  for (int edge = 0; edge < 4; ++edge) {
    std::vector<geo::Vec3> samples;
    for (int i = 0; i <= grid.cells; i += step)
      samples.push_back(pointAt(grid, edgePoint(edge, i, grid.cells)));
    const std::vector<std::uint8_t> kept = keptAlongEdge(samples, tolerance_m, keepMiddle);
    auto& out = flags[static_cast<std::size_t>(edge)];
    out.assign(static_cast<std::size_t>(grid.cells) + 1, 0);
    for (std::size_t i = 0; i < kept.size(); ++i)
      out[i * static_cast<std::size_t>(step)] = kept[i];
  }
  return flags;
}

/// All vertices that the parent has on the tile's edges. On the parent's own edges they are what a coarser neighbour
/// has, whatever that knows of the ground: where samples of parents are samples of their children, what flagsOfEdges
/// finds. Through its middle the parent may have more, for the sake of the ground beside the line; there a coarse edge
/// is drawn where a part of the parent's mesh stands for the tile beyond (patchMesh).
void takeParentsFlags(const ParentSurface& parent, EdgeFlags& coarse, EdgeFlags& fine) {
  for (int edge = 0; edge < 4; ++edge) {
    const auto e = static_cast<std::size_t>(edge);
    const auto cells = static_cast<int>(fine[e].size()) - 1;
    for (int i = 0; i <= cells; ++i) {
      const GridPoint p = edgePoint(edge, i, cells);
      const std::uint8_t has =
          parent.isVertex[static_cast<std::size_t>(p.row * (cells + 1)) + static_cast<std::size_t>(p.col)];
      const auto at = static_cast<std::size_t>(i);
      fine[e][at] = fine[e][at] | has;
      coarse[e][at] = has;
    }
  }
}

/// Collects vertices and indices of one mesh.
class MeshWriter {
 public:
  MeshWriter(const SurfaceGrid& grid, double vertexGrid_m, double parentStep_m, const ParentSurface* parent)
      : grid_(grid), vertexGrid_m_(vertexGrid_m), parent_(parent) {
    mesh_.parentStep_m = static_cast<float>(parentStep_m);
    const auto middle = static_cast<std::int16_t>(grid.cells / 2);
    mesh_.origin = {rounded(pointAt(grid, {middle, middle}), std::max(kOriginGrid_m, vertexGrid_m))};
    mesh_.serial = nextSerial();
    vertexOf_.assign(static_cast<std::size_t>((grid.cells + 1) * (grid.cells + 1)), kNoVertex);
  }

  IndexRange add(const std::vector<GridTriangle>& triangles) {
    const IndexRange range{static_cast<std::uint32_t>(mesh_.indices.size()),
                           static_cast<std::uint32_t>(triangles.size() * 3)};
    for (const GridTriangle& t : triangles) {
      for (const GridPoint p : t)
        mesh_.indices.push_back(vertex(p));
    }
    return range;
  }
  TerrainMesh& mesh() { return mesh_; }
  /// The longest way from a vertex to the parent's surface.
  double reach_m() const { return std::sqrt(reach2_) * static_cast<double>(mesh_.parentStep_m); }

 private:
  std::size_t slot(GridPoint p) const {
    return static_cast<std::size_t>(p.row) * static_cast<std::size_t>(grid_.cells + 1) +
           static_cast<std::size_t>(p.col);
  }

  std::uint16_t vertex(GridPoint p) {
    std::uint16_t& known = vertexOf_[slot(p)];
    if (known == kNoVertex) {
      known = static_cast<std::uint16_t>(mesh_.vertices.size());
      mesh_.vertices.push_back(make(p));
    }
    return known;
  }

  /// In steps; what lies further away than 16 bits can say morphs from as near as they can.
  std::array<std::int16_t, 4> toParent(GridPoint p, const geo::Vec3& own, double height_m) {
    if (parent_ == nullptr) return {};
    const auto steps = [&](double metres) {
      const double step_m = static_cast<double>(mesh_.parentStep_m);
      return static_cast<std::int16_t>(std::clamp(std::round(metres / step_m), -32767.0, 32767.0));
    };
    const geo::Vec3 way = parent_->positions[slot(p)] - own;
    const std::array out{steps(way.x), steps(way.y), steps(way.z), steps(parent_->heights_m[slot(p)] - height_m)};
    const geo::Vec3 inSteps(out[0], out[1], out[2]);
    reach2_ = std::max(reach2_, geo::dot(inSteps, inSteps));
    return out;
  }

  bool isParentsEdgeVertex(GridPoint p) const {
    const bool isOnEdge = std::min(p.col, p.row) == 0 || std::max(p.col, p.row) == grid_.cells;
    return isOnEdge && parent_->isVertex[slot(p)] != 0;
  }

  /// Where it is a vertex of the parent's edge, a vertex is a whole number of steps from there, so that it can go back
  /// exactly; where both are of the same data, none.
  void goToSteps(GridPoint p, geo::Vec3& own, double& height_m) const {
    if (parent_ == nullptr || !isParentsEdgeVertex(p)) return;
    const double step_m = static_cast<double>(mesh_.parentStep_m);
    const auto nearest = [&](double from, double value) {
      return from + std::clamp(std::round((value - from) / step_m), -32767.0, 32767.0) * step_m;
    };
    const geo::Vec3& from = parent_->positions[slot(p)];
    own = {nearest(from.x, own.x), nearest(from.y, own.y), nearest(from.z, own.z)};
    height_m = nearest(parent_->heights_m[slot(p)], height_m);
  }

  TerrainVertex make(GridPoint p) {
    const auto normalised = [](double v) { return static_cast<std::int16_t>(std::lround(v * 32767.0)); };
    const auto share = [&](int i) { return static_cast<std::uint16_t>(i * (kPlaceUnits / grid_.cells)); };
    const geo::Vec3 up = grid_.up[grid_.index(p.col, p.row)].n;
    geo::Vec3 own = rounded(pointAt(grid_, p), vertexGrid_m_);
    double height_m = static_cast<double>(grid_.heights_m[grid_.index(p.col, p.row)]);
    goToSteps(p, own, height_m);
    const geo::Vec3 exact = own - mesh_.origin.m;
    const geo::Vec3f single(exact);
    const geo::Vec3 rest = (exact - geo::Vec3(single)) / vertexGrid_m_;
    const auto steps = [](double v) { return static_cast<std::int16_t>(std::lround(v)); };
    return {.position_tile = single,
            .up_body = {normalised(up.x), normalised(up.y), normalised(up.z)},
            .s = share(p.col),
            .fine_tile = {steps(rest.x), steps(rest.y), steps(rest.z)},
            .t = share(p.row),
            .toParent = toParent(p, own, height_m),
            .height_m = static_cast<float>(height_m)};
  }

  const SurfaceGrid& grid_;
  double vertexGrid_m_;
  const ParentSurface* parent_;
  double reach2_ = 0.0;  ///< in steps, squared
  TerrainMesh mesh_;
  std::vector<std::uint16_t> vertexOf_;
};

OrientedBox boxOf(const SurfaceGrid& grid, double margin_m) {
  std::vector<geo::BodyPosition> points;
  points.reserve(static_cast<std::size_t>((grid.cells + 1) * (grid.cells + 1)));
  for (int row = 0; row <= grid.cells; ++row) {
    const auto first = grid.positions.begin() + static_cast<std::ptrdiff_t>(grid.index(0, row));
    points.insert(points.end(), first, first + grid.cells + 1);
  }
  const int middle = grid.cells / 2;
  const geo::Vec3 across = grid.positions[grid.index(grid.cells, middle)] - grid.positions[grid.index(0, middle)];
  return boxAround(points, across, grid.up[grid.index(middle, middle)].n, margin_m);
}

/// How far the ellipsoid's normals lean away from the middle one.
void setNormals(const SurfaceGrid& grid, TerrainMesh& mesh) {
  const geo::Vec3 middle = grid.up[grid.index(grid.cells / 2, grid.cells / 2)].n;
  double most2 = 0.0;
  for (int row = 0; row <= grid.cells; ++row) {
    for (int col = 0; col <= grid.cells; ++col) {
      const geo::Vec3 apart = grid.up[grid.index(col, row)].n - middle;
      most2 = std::max(most2, geo::dot(apart, apart));
    }
  }
  constexpr double kRounding = 1e-4;  // of normals with 16 bits an axis
  mesh.middleUp_body = geo::Vec3f(middle);
  mesh.upReach = static_cast<float>(std::sqrt(most2) + kRounding);
}

/// How far it reaches, morphed too: toParent is a way in steps.
void setReach(TerrainMesh& mesh) {
  double reach_m = 0.0;
  double highest_m = 0.0;
  for (const TerrainVertex& v : mesh.vertices) {
    const geo::Vec3 here(v.position_tile);
    const double step = static_cast<double>(mesh.parentStep_m);
    const geo::Vec3 way = step * geo::Vec3(v.toParent[0], v.toParent[1], v.toParent[2]);
    reach_m = std::max({reach_m, geo::length(here), geo::length(here + way)});
    const double height_m = static_cast<double>(v.height_m);
    highest_m = std::max({highest_m, std::abs(height_m), std::abs(height_m + step * v.toParent[3])});
  }
  constexpr double kRounding_m = 2.0;  // of the fine parts of vertices, and of single precision
  mesh.reach_m = static_cast<float>(1.001 * reach_m + kRounding_m);
  mesh.highest_m = static_cast<float>(1.001 * highest_m + kRounding_m);
}

}  // namespace

std::uint64_t nextSerial() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

double meshTolerance_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, int level, int cells) {
  // There the chords across a quarter of a tile, diagonals too, are 0.26 spacings off the sphere: with less it would
  // take twice the triangles. Coarse edges stay a part of the fine ones: a level's tolerance is less than the one
  // above.
  const bool isBent = tiling.scheme() == tiling::Scheme::healpix && level == 2;
  return (isBent ? kBentMeshToleranceShare : kMeshToleranceShare) * meanEdge_m(tiling, ellipsoid, level) / cells;
}

double vertexGrid_m(const geo::Ellipsoid& ellipsoid) {
  return std::exp2(std::max(std::ceil(std::log2(2.0 * ellipsoid.semiMajorAxis_m())), 24.0) - 39.0);
}

MadeMesh makeTerrainMesh(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                         const TerrainMesh* parent, bool regular) {
  constexpr double kKeepAll_m = -1.0;
  const auto toleranceOf = [&](int level) {
    return regular ? kKeepAll_m : meshTolerance_m(tiling, ellipsoid, level, grid.cells);
  };
  const double tolerance_m = toleranceOf(grid.id.level);
  const double parentTolerance_m = toleranceOf(grid.id.level - 1);
  std::vector<geo::Vec3> points;
  points.reserve(static_cast<std::size_t>((grid.cells + 1) * (grid.cells + 1)));
  for (std::int16_t row = 0; row <= grid.cells; ++row) {
    for (std::int16_t col = 0; col <= grid.cells; ++col)
      points.push_back(pointAt(grid, {col, row}));
  }
  const double vertexStep_m = vertexGrid_m(ellipsoid);
  std::optional<ParentSurface> from;
  if (parent != nullptr) from = parentSurface(*parent, vertexStep_m, grid.id.quadrant(), grid.cells);
  EdgeFlags fine = flagsOfEdges(grid, 1, tolerance_m, true);
  EdgeFlags coarse = flagsOfEdges(grid, 2, parentTolerance_m, false);
  if (from) takeParentsFlags(*from, coarse, fine);
  BisectionRule rule{.surfaces = {points}, .tolerance_m = tolerance_m, .kept = {}};
  if (from) {
    rule.surfaces.emplace_back(from->positions);
    rule.kept = from->isVertex;
  }
  const Triangulation triangles = triangulate(rule, grid.cells, fine, coarse);
  MeshWriter writer(grid, vertexStep_m, parentStep_m(tiling, ellipsoid, grid.id.level, grid.cells),
                    from ? &*from : nullptr);
  TerrainMesh& mesh = writer.mesh();
  mesh.interior = writer.add(triangles.interior);
  for (std::size_t e = 0; e < 4; ++e)
    mesh.fineEdge[e] = writer.add(triangles.fine[e]);
  for (std::size_t e = 0; e < 4; ++e)
    mesh.coarseEdge[e] = writer.add(triangles.coarse[e]);
  setNormals(grid, mesh);
  setReach(mesh);
  const double reach_m = writer.reach_m();
  const double error_m = meshError_m(tiling, ellipsoid, grid, triangles);
  return {.mesh = std::make_shared<const TerrainMesh>(std::move(mesh)),
          .box = boxOf(grid, error_m + reach_m),
          .error_m = error_m};
}

}  // namespace tellurion::scene
