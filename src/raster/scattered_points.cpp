#include "raster/scattered_points.h"

#include <algorithm>
#include <array>
#include <span>
#include <tuple>

namespace tellurion::raster {
namespace {

using tiling::kMaxLevel;
using tiling::TileId;

constexpr int kDense = 16;  ///< of the 64 sub-cells of four cells
constexpr int kSubLevels = 2;
constexpr int kThinnedLevels = 4;  ///< an eighth of a spacing
constexpr int kFewPoints = 16;

/// The first point of a run that lies in `cell`, of the deepest level, or behind it.
std::size_t lowerBound(const std::vector<PackedPoint>& points, ScatteredPoints::Run run, std::uint64_t cell) {
  const auto begin = points.begin() + static_cast<std::ptrdiff_t>(run.first);
  const auto end = points.begin() + static_cast<std::ptrdiff_t>(run.last);
  return static_cast<std::size_t>(std::ranges::lower_bound(begin, end, cell, {}, &PackedPoint::cell) - points.begin());
}

}  // namespace

ScatteredPoints::ScatteredPoints(std::vector<PackedPoint> points, int mergeLevel) : points_(std::move(points)) {
  std::ranges::sort(points_, [](const PackedPoint& a, const PackedPoint& b) {
    return std::tie(a.cell, a.u, a.v, a.height_m) < std::tie(b.cell, b.u, b.v, b.height_m);
  });
  merge(mergeLevel);
  findSpacings();
  collectCells();
  thinCrowded();
  findArea();
}

void ScatteredPoints::merge(int mergeLevel) {
  const auto isOne = [&](const PackedPoint& a, const PackedPoint& b) {
    if (mergeLevel < kMaxLevel) return cellOf(a, mergeLevel) == cellOf(b, mergeLevel);
    return std::tie(a.cell, a.u, a.v) == std::tie(b.cell, b.u, b.v);
  };
  std::size_t kept = 0;
  for (std::size_t first = 0, last = 0; first < points_.size(); first = last) {
    last = first + 1;
    while (last < points_.size() && isOne(points_[first], points_[last]))
      ++last;
    points_[kept++] = meanPoint(std::span(points_).subspan(first, last - first));
  }
  points_.resize(kept);
}

geo::Angle ScatteredPoints::spacingOf(int spacingLevel) {
  return kPointIndex.metrics(spacingLevel).meanEdge / 2.0;
}

ScatteredPoints::Run ScatteredPoints::below(const TileId& cell, Run within) const {
  const int shift = 2 * (kMaxLevel - cell.level);
  const std::uint64_t number = tiling::healpixNested(cell);
  const std::size_t first = lowerBound(points_, within, number << shift);
  return {first, lowerBound(points_, {first, within.last}, (number + 1) << shift)};
}

/// Of the 16 sub-cells of a cell, how many hold a point.
int ScatteredPoints::occupied(const TileId& cell) const {
  const Run run = below(cell, all());
  const int shift = 2 * (kMaxLevel - cell.level - kSubLevels);
  int count = 0;
  for (std::size_t i = run.first; i < run.last; ++count) {
    const std::uint64_t next = ((points_[i].cell >> shift) + 1) << shift;
    const std::size_t last = std::min(run.last, i + kFewPoints);
    while (i < last && points_[i].cell < next)
      ++i;
    if (i == last) i = lowerBound(points_, {i, run.last}, next);
  }
  return count;
}

/// Marks what no deeper level has; false: all points have a level.
bool ScatteredPoints::markDense(int level) {
  constexpr std::array<std::pair<tiling::Corner, std::array<tiling::Edge, 2>>, 4> kSquares{{
      {tiling::Corner::topLeft, {tiling::Edge::top, tiling::Edge::left}},
      {tiling::Corner::topRight, {tiling::Edge::top, tiling::Edge::right}},
      {tiling::Corner::bottomRight, {tiling::Edge::bottom, tiling::Edge::right}},
      {tiling::Corner::bottomLeft, {tiling::Edge::bottom, tiling::Edge::left}},
  }};
  bool isOpen = false;
  for (std::size_t first = 0, last = 0; first < points_.size(); first = last) {
    const std::uint64_t number = cellOf(points_[first], level);
    bool hasOpen = false;
    for (last = first; last < points_.size() && cellOf(points_[last], level) == number; ++last)
      hasOpen = hasOpen || levels_[last] == kNoLevel;
    if (!hasOpen) continue;
    const TileId cell = tiling::tileFromHealpixNested(level, number);
    const int own = occupied(cell);
    bool isDense = false;
    for (const auto& [corner, edges] : kSquares) {
      int sum = own;
      for (const tiling::Edge edge : edges)
        sum += occupied(kPointIndex.edgeNeighbour(cell, edge).tile);
      const auto across = kPointIndex.cornerNeighbour(cell, corner);
      if (across) sum += occupied(*across);
      // Three cells meet in the cube's own corners.
      isDense = isDense || sum * 4 >= kDense * (across ? 4 : 3);
    }
    if (isDense) {
      for (std::size_t i = first; i < last; ++i) {
        if (levels_[i] == kNoLevel) levels_[i] = static_cast<std::int8_t>(level);
      }
    } else {
      isOpen = true;
    }
  }
  return isOpen;
}

void ScatteredPoints::findSpacings() {
  levels_.assign(points_.size(), kNoLevel);
  for (int level = kMaxLevel - kThinnedLevels; level >= 1; --level) {
    // A dense square has a cell with four points at least: most levels below the deepest dense one have none.
    const int shift = 2 * (kMaxLevel - level);
    bool mayBeDense = false;
    for (std::size_t i = 3; i < points_.size() && !mayBeDense; ++i)
      mayBeDense = points_[i].cell >> shift == points_[i - 3].cell >> shift;
    if (mayBeDense && !markDense(level)) return;
  }
}

void ScatteredPoints::collectCells() {
  std::array<std::vector<std::uint64_t>, kMaxLevel + 1> cells;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (levels_[i] == kNoLevel) continue;
    auto& of = cells[static_cast<std::size_t>(levels_[i])];
    const std::uint64_t number = cellOf(points_[i], levels_[i]);
    if (of.empty() || of.back() != number) of.push_back(number);
  }
  for (int level = 0; level <= kMaxLevel; ++level) {
    auto& of = cells[static_cast<std::size_t>(level)];
    if (of.empty()) continue;
    present_.push_back(level);
    cells_.push_back(std::move(of));
  }
}

void ScatteredPoints::thinCrowded() {
  std::vector<bool> isDropped(points_.size(), false);
  for (const int level : present_) {
    for (std::size_t first = 0, last = 0; first < points_.size(); first = last) {
      std::size_t count = 0;
      const std::uint64_t cell = cellOf(points_[first], level);
      for (last = first; last < points_.size() && cellOf(points_[last], level) == cell; ++last)
        count += levels_[last] == level ? 1u : 0u;
      if (count <= kCrowded) continue;
      std::uint64_t kept = ~std::uint64_t{0};
      for (std::size_t i = first; i < last; ++i) {
        if (levels_[i] != level) continue;
        const std::uint64_t part = cellOf(points_[i], level + kThinnedLevels);
        isDropped[i] = part == kept;
        kept = part;
      }
    }
  }
  std::size_t left = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (isDropped[i]) continue;
    points_[left] = points_[i];
    levels_[left++] = levels_[i];
  }
  points_.resize(left);
  levels_.resize(left);
}

void ScatteredPoints::findArea() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const geo::Geodetic at = geo::geodeticFromDirection(placeOf(points_[i]));
    const geo::GeoRect own{.south = at.lat, .north = at.lat, .west = at.lon, .width = {}};
    if (i == 0) area_ = own;
    if (!area_.contains(at.lat, at.lon)) area_ = area_.united(own);
  }
}

namespace {

bool isApart(const tiling::Cap& a, const tiling::Cap& b, geo::Angle reach) {
  constexpr double kRounding = 1e-12;
  return geo::angleBetween(a.centre, b.centre).radians() >
         a.radius.radians() + b.radius.radians() + reach.radians() + kRounding;
}

template <class Visit>
void descend(const Visit& visit) {
  for (int root = 0; root < kPointIndex.rootCount(); ++root)
    visit(TileId{.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0});
}

}  // namespace

std::vector<ScatteredPoints::Run> ScatteredPoints::near(const tiling::Cap& cap, geo::Angle reach, int cellLevel) const {
  struct Node {
    TileId cell;
    Run run;
  };
  std::vector<Run> runs;
  std::vector<Node> open;
  descend([&](const TileId& root) { open.push_back({root, below(root, all())}); });
  while (!open.empty()) {
    const Node node = open.back();
    open.pop_back();
    if (node.run.size() == 0 || isApart(kPointIndex.cap(node.cell), cap, reach)) continue;
    if (node.cell.level >= cellLevel || node.run.size() <= kFewPoints) {
      runs.push_back(node.run);
      continue;
    }
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId child = node.cell.child(quadrant);
      open.push_back({child, below(child, node.run)});
    }
  }
  std::ranges::sort(runs, {}, &Run::first);
  return runs;
}

bool ScatteredPoints::mayBeNear(int spacingLevel, const tiling::Cap& cap, geo::Angle reach) const {
  const auto which = std::ranges::find(present_, spacingLevel);
  if (which == present_.end()) return false;
  const auto& cells = cells_[static_cast<std::size_t>(which - present_.begin())];
  std::vector<TileId> open;
  descend([&](const TileId& root) { open.push_back(root); });
  while (!open.empty()) {
    const TileId cell = open.back();
    open.pop_back();
    const int shift = 2 * (spacingLevel - cell.level);
    const std::uint64_t number = tiling::healpixNested(cell);
    const auto first = std::ranges::lower_bound(cells, number << shift);
    if (first == cells.end() || *first >= (number + 1) << shift) continue;
    if (isApart(kPointIndex.cap(cell), cap, reach)) continue;
    if (cell.level == spacingLevel) return true;
    for (int quadrant = 0; quadrant < 4; ++quadrant)
      open.push_back(cell.child(quadrant));
  }
  return false;
}

std::vector<TileId> ScatteredPoints::cellsOf(int spacingLevel, int cellLevel) const {
  std::vector<TileId> result;
  const auto which = std::ranges::find(present_, spacingLevel);
  if (which == present_.end()) return result;
  const int level = std::min(spacingLevel, cellLevel);
  for (const std::uint64_t cell : cells_[static_cast<std::size_t>(which - present_.begin())]) {
    const TileId id = tiling::tileFromHealpixNested(level, cell >> (2 * (spacingLevel - level)));
    if (result.empty() || result.back() != id) result.push_back(id);
  }
  return result;
}

}  // namespace tellurion::raster
