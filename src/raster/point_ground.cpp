#include "raster/point_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "geo/shared_rect.h"
#include "raster/raster.h"

namespace tellurion::raster {
namespace {

using tiling::TileId;

constexpr int kBlockLevels = 4;  ///< above a spacing's cells: 32 spacings a side
constexpr int kThinFrom = 2;     ///< levels below a spacing's: points as dense are thinned
constexpr int kThinLevels = 2;   ///< below a spacing's cells: half a spacing
/// In spacings, around a place: what decides about its height lies in the circle of its triangle, or, where that is
/// ground for the sake of one beside it, in that one's too. So far a level's ground reaches, too.
constexpr double kAround = 4.0 * PointGround::kWidestCircle + 0.1;

/// The points that a block is triangulated from, in the order of all points.
struct BlockPoints {
  std::vector<geo::Direction> places;
  std::vector<float> heights_m;
  std::vector<int> levels;  ///< of spacing

  void add(const PackedPoint& point, int level, const StereographicPlane& plane) {
    const geo::Direction place = placeOf(point);
    if (!plane.holds(place)) return;
    places.push_back(place);
    heights_m.push_back(point.height_m);
    levels.push_back(level);
  }
};

/// Which points stay is decided cell by cell, so all blocks of a level that see a place see the same points there.
BlockPoints blockPoints(const ScatteredPoints& points, const tiling::Cap& cap, int level,
                        const StereographicPlane& plane) {
  const int thinLevel = std::min(level + kThinLevels, tiling::kMaxLevel);
  BlockPoints found;
  for (const ScatteredPoints::Run& run : points.near(cap, ScatteredPoints::spacingOf(level) * kAround, level)) {
    std::uint64_t last = ~std::uint64_t{0};
    for (std::size_t i = run.first; i < run.last; ++i) {
      const int own = points.spacingLevel(i);
      if (own != ScatteredPoints::kNoLevel && own < level + kThinFrom) {
        found.add(points.point(i), own, plane);
        continue;
      }
      const std::uint64_t cell = cellOf(points.point(i), thinLevel);
      if (cell == last) continue;
      last = cell;
      found.add(points.point(i), own, plane);
    }
  }
  return found;
}

/// Of the circle through three places, in the unit sphere's space.
double radiusOfCircle(const geo::Direction& a, const geo::Direction& b, const geo::Direction& c) {
  const geo::Vec3 ab = b.n - a.n;
  const geo::Vec3 ac = c.n - a.n;
  return geo::length(ab) * geo::length(ac) * geo::length(c.n - b.n) / (2.0 * geo::length(geo::cross(ab, ac)));
}

/// The widest spacing among a triangle's corners, as a level (coarser is less); kNoLevel: none has one.
int widestSpacing(const BlockPoints& points, const Triangle& triangle) {
  int widest = std::numeric_limits<int>::max();
  for (const std::uint32_t corner : triangle) {
    if (points.levels[corner] != ScatteredPoints::kNoLevel) widest = std::min(widest, points.levels[corner]);
  }
  return widest == std::numeric_limits<int>::max() ? ScatteredPoints::kNoLevel : widest;
}

bool hasSmallCircle(const BlockPoints& points, Triangle triangle, int level) {
  std::ranges::sort(triangle);  // the same bits in all blocks
  const double radius =
      radiusOfCircle(points.places[triangle[0]], points.places[triangle[1]], points.places[triangle[2]]);
  return radius <= std::sin(PointGround::kWidestCircle * ScatteredPoints::spacingOf(level).radians());
}

/// Those whose widest spacing is the level's, and the denser ones that share a corner with one: these fill bays in the
/// border of what is denser, and thinned points may lie before or behind that border.
std::vector<Triangle> groundOf(const BlockPoints& points, std::vector<Triangle> triangles, int level) {
  std::erase_if(triangles, [&](const Triangle& triangle) {
    return widestSpacing(points, triangle) < level || !hasSmallCircle(points, triangle, level);
  });
  std::vector<bool> isOfLevel(points.places.size(), false);
  for (const Triangle& triangle : triangles) {
    if (widestSpacing(points, triangle) != level) continue;
    for (const std::uint32_t corner : triangle)
      isOfLevel[corner] = true;
  }
  std::erase_if(triangles, [&](const Triangle& triangle) {
    return std::ranges::none_of(triangle, [&](std::uint32_t corner) { return isOfLevel[corner]; });
  });
  return triangles;
}

/// Without what lies wholly beside the cell.
GroundBlock blockOf(const TileId& cell, const StereographicPlane& plane, const BlockPoints& points,
                    std::vector<Triangle> triangles) {
  const auto corner = [&](double s, double t) { return kPointIndex.direction(tiling::rootPointIn(cell, s, t)); };
  const auto box = plane.boxAround(std::array{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)});
  std::erase_if(triangles, [&](const Triangle& t) {
    return !plane.boxAround(std::array{points.places[t[0]], points.places[t[1]], points.places[t[2]]}).meets(box);
  });
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  std::vector<std::uint32_t> kept(points.places.size(), kUnused);
  std::vector<GroundBlock::Corner> corners;
  for (Triangle& triangle : triangles) {
    for (std::uint32_t& i : triangle) {
      if (kept[i] == kUnused) {
        kept[i] = static_cast<std::uint32_t>(corners.size());
        corners.push_back({.place = points.places[i], .height_m = points.heights_m[i]});
      }
      i = kept[i];
    }
  }
  corners.shrink_to_fit();
  triangles.shrink_to_fit();
  return {plane, std::move(corners), std::move(triangles)};
}

}  // namespace

std::size_t PointGround::BlockIdHash::operator()(const BlockId& id) const noexcept {
  return tiling::TileIdHash{}(id.cell) * 31 + static_cast<std::size_t>(id.spacingLevel);
}

PointGround::PointGround(ScatteredPoints points, std::uint64_t cacheBytes)
    : points_(std::move(points)), cacheBytes_(cacheBytes), blocks_(cacheBytes) {}

geo::GeoRect PointGround::bounds(int spacingLevel) const {
  constexpr int kRoughLevel = 16;  ///< 150 m on Earth
  std::optional<geo::GeoRect> rect;
  for (const TileId& cell : points_.cellsOf(spacingLevel, kRoughLevel)) {
    const geo::GeoRect own = kPointIndex.bounds(cell);
    rect = rect ? rect->united(own) : own;
  }
  const geo::Angle spacing = ScatteredPoints::spacingOf(spacingLevel);
  const geo::GeoRect reached = rect.value_or(geo::GeoRect{}).grown(spacing * kAround);
  const geo::GeoRect most = points_.area().grown(spacing * kAround);
  const bool hasPole = std::max(most.north.degrees(), -most.south.degrees()) >= 90.0;
  // Sides are great circles, which so far from the poles bulge by less than a spacing beyond the parallel of their
  // ends.
  return hasPole ? reached : geo::sharedRect(reached, points_.area().grown(spacing)).value_or(reached);
}

bool PointGround::mayTouch(int spacingLevel, const tiling::Tiling& tiling, const TileId& id, geo::Angle within) const {
  return points_.mayBeNear(spacingLevel, tiling.cap(id), within + ScatteredPoints::spacingOf(spacingLevel) * kAround);
}

std::shared_ptr<const GroundBlock> PointGround::makeBlock(const BlockId& id) const {
  const geo::Angle spacing = ScatteredPoints::spacingOf(id.spacingLevel);
  const tiling::Cap cap = kPointIndex.cap(id.cell);
  if (!points_.mayBeNear(id.spacingLevel, cap, spacing * kAround)) return nullptr;
  const StereographicPlane plane(cap.centre, spacing.radians());
  const BlockPoints points = blockPoints(points_, cap, id.spacingLevel, plane);
  std::vector<Triangle> ground = groundOf(points, delaunayTriangles(points.places, plane), id.spacingLevel);
  if (ground.empty()) return nullptr;
  return std::make_shared<const GroundBlock>(blockOf(id.cell, plane, points, std::move(ground)));
}

io::Result<void> PointGround::sampleHeights(int spacingLevel, std::span<const geo::Direction> places,
                                            std::span<float> out) const {
  std::vector<std::pair<TileId, std::size_t>> byBlock;
  byBlock.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    byBlock.emplace_back(kPointIndex.tileAt(places[i], std::max(0, spacingLevel - kBlockLevels)), i);
  std::ranges::sort(byBlock);
  std::shared_ptr<const GroundBlock> block;
  for (std::size_t k = 0; k < byBlock.size(); ++k) {
    const auto& [cell, i] = byBlock[k];
    if (k == 0 || byBlock[k - 1].first != cell) {
      const BlockId id{spacingLevel, cell};
      auto found = blocks_.get(
          id, [&]() -> io::Result<std::shared_ptr<const GroundBlock>> { return makeBlock(id); },
          [](const GroundBlock& b) { return b.bytes(); });
      if (!found) return tl::unexpected(std::move(found.error()));
      block = std::move(*found);
    }
    if (!block) continue;
    const float height_m = block->heightAt(places[i]);
    if (!isNoData(height_m)) out[i] = height_m;
  }
  return {};
}

}  // namespace tellurion::raster
