#include "scene/mesh_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

namespace tellurion::scene {
namespace {

/// Squared distances from the ground to one triangle: at the samples inside, and where its sides cross lines of
/// samples. Not more than what is left when one looks aside: ground and triangle pass through all heights between the
/// corners', so at a cliff they are no further apart than the triangle is long, but for ground above or below all
/// corners.
class TriangleError {
 public:
  TriangleError(const SurfaceGrid& grid, const GridTriangle& t, double cellSide_m)
      : grid_(grid),
        t_(t),
        corners_{pointAt(grid, t[0]), pointAt(grid, t[1]), pointAt(grid, t[2])},
        cellSide_m_(cellSide_m) {
    std::tie(low_m_, high_m_) = std::minmax({heightAt(t[0]), heightAt(t[1]), heightAt(t[2])});
  }

  double worst2() {
    const double area = doubleArea(t_[0], t_[1], t_[2]);
    if (area > 1.0) atSamples(area);  // else half a cell: no sample but its corners
    for (std::size_t i = 0; i < 3; ++i)
      alongSide(i, (i + 1) % 3);
    return std::min(worst2_, longest2() + beyond_m_ * beyond_m_);
  }

 private:
  double heightAt(GridPoint p) const { return static_cast<double>(grid_.heights_m[grid_.index(p.col, p.row)]); }

  double longest2() const {
    int longest2 = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const int across = t_[(i + 1) % 3].col - t_[i].col;
      const int down = t_[(i + 1) % 3].row - t_[i].row;
      longest2 = std::max(longest2, across * across + down * down);
    }
    return longest2 * cellSide_m_ * cellSide_m_;
  }

  void compare(const geo::Vec3& ground, double height_m, const geo::Vec3& drawn) {
    worst2_ = std::max(worst2_, geo::dot(ground - drawn, ground - drawn));
    beyond_m_ = std::max({beyond_m_, height_m - high_m_, low_m_ - height_m});
  }

  void atSamples(double area) {
    const auto [west, east] = std::minmax({t_[0].col, t_[1].col, t_[2].col});
    const auto [north, south] = std::minmax({t_[0].row, t_[1].row, t_[2].row});
    for (auto row = north; row <= south; ++row) {
      for (auto col = west; col <= east; ++col) {
        const GridPoint p{col, row};
        const int w0 = doubleArea(t_[1], t_[2], p);
        const int w1 = doubleArea(t_[2], t_[0], p);
        const int w2 = doubleArea(t_[0], t_[1], p);
        if (w0 < 0 || w1 < 0 || w2 < 0) continue;
        compare(pointAt(grid_, p), heightAt(p),
                (corners_[0] * double(w0) + corners_[1] * double(w1) + corners_[2] * double(w2)) / area);
      }
    }
  }

  void alongSide(std::size_t from, std::size_t to) {
    const int across = t_[to].col - t_[from].col;
    const int down = t_[to].row - t_[from].row;
    if (across == 0 || down == 0 || std::abs(across) == std::abs(down)) return;  // through samples only
    for (int i = 1; i < std::abs(across); ++i)
      crossing(from, to, double(i) / std::abs(across));
    for (int i = 1; i < std::abs(down); ++i)
      crossing(from, to, double(i) / std::abs(down));
  }

  void crossing(std::size_t from, std::size_t to, double share) {
    const double col = std::lerp(double(t_[from].col), double(t_[to].col), share);
    const double row = std::lerp(double(t_[from].row), double(t_[to].row), share);
    const auto c = static_cast<std::int16_t>(std::min(std::floor(col), grid_.cells - 1.0));
    const auto r = static_cast<std::int16_t>(std::min(std::floor(row), grid_.cells - 1.0));
    const auto right = static_cast<std::int16_t>(c + 1);
    const auto below = static_cast<std::int16_t>(r + 1);
    const geo::Vec3 upper = glm::mix(pointAt(grid_, {c, r}), pointAt(grid_, {right, r}), col - c);
    const geo::Vec3 lower = glm::mix(pointAt(grid_, {c, below}), pointAt(grid_, {right, below}), col - c);
    const double upper_m = std::lerp(heightAt({c, r}), heightAt({right, r}), col - c);
    const double lower_m = std::lerp(heightAt({c, below}), heightAt({right, below}), col - c);
    compare(glm::mix(upper, lower, row - r), std::lerp(upper_m, lower_m, row - r),
            glm::mix(corners_[from], corners_[to], share));
  }

  const SurfaceGrid& grid_;
  const GridTriangle& t_;
  std::array<geo::Vec3, 3> corners_;
  double cellSide_m_;
  double low_m_ = 0.0;  ///< of the corners
  double high_m_ = 0.0;
  double worst2_ = 0.0;
  double beyond_m_ = 0.0;  ///< by which ground leaves the corners' heights
};

/// The middle of a cell: where the ground is, bilinear in height.
geo::Vec3 groundInCell(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                       GridPoint cell) {
  const auto heightAt = [&](int right, int down) {
    return static_cast<double>(grid.heights_m[grid.index(cell.col + right, cell.row + down)]);
  };
  const geo::Direction up =
      tiling.direction(tiling::rootPointIn(grid.id, (cell.col + 0.5) / grid.cells, (cell.row + 0.5) / grid.cells));
  return ellipsoid.bodyFromDirection(up, 0.25 * (heightAt(0, 0) + heightAt(1, 0) + heightAt(0, 1) + heightAt(1, 1))).m;
}

/// The squared distance between two samples as the map has it, their heights apart.
double level2(const SurfaceGrid& grid, GridPoint a, GridPoint b) {
  const geo::Vec3 way = pointAt(grid, b) - pointAt(grid, a);
  const double up = geo::dot(way, grid.up[grid.index(a.col, a.row)].n);
  return geo::dot(way, way) - up * up;
}

/// What the bilinear ground in each cell is off, at most.
struct CellErrors {
  int cells = 0;
  std::vector<double> worst_m;  ///< row-major

  double at(int col, int row) const {
    return worst_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells) + static_cast<std::size_t>(col)];
  }
  /// The largest of the cells that a triangle covers some of.
  double under(const GridTriangle& t) const;
};

/// Whether the inside of a square of one cell and that of a triangle meet: no side of the triangle has all of the cell
/// beyond it. (Cells beyond its outermost columns and rows are not asked for.)
bool covers(const GridTriangle& t, std::int16_t col, std::int16_t row) {
  for (std::size_t i = 0; i < 3; ++i) {
    int inmost = std::numeric_limits<int>::min();
    for (std::int16_t q = 0; q < 4; ++q) {
      const GridPoint corner{static_cast<std::int16_t>(col + (q & 1)), static_cast<std::int16_t>(row + (q >> 1))};
      inmost = std::max(inmost, doubleArea(t[i], t[(i + 1) % 3], corner));
    }
    if (inmost <= 0) return false;
  }
  return true;
}

double CellErrors::under(const GridTriangle& t) const {
  const auto [west, east] = std::minmax({t[0].col, t[1].col, t[2].col});
  const auto [north, south] = std::minmax({t[0].row, t[1].row, t[2].row});
  double worst = 0.0;
  for (auto row = north; row < south; ++row) {
    for (auto col = west; col < east; ++col) {
      if (at(col, row) > worst && covers(t, col, row)) worst = at(col, row);
    }
  }
  return worst;
}

/// How far the bilinear ground between four samples is from the triangles between them, at most, but for curvature: at
/// the middle of the cell, against either diagonal. On the tile's diagonals, which no triangle crosses, against the
/// diagonal itself: the map may have a crease there, and then so has the mesh. In a cliff that is far up or down, but
/// both surfaces pass through every height between the corners' somewhere in the cell: no further aside than the cell
/// is wide.
CellErrors errorsWithinCells(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid) {
  CellErrors errors{.cells = grid.cells, .worst_m = {}};
  errors.worst_m.reserve(static_cast<std::size_t>(grid.cells) * static_cast<std::size_t>(grid.cells));
  const auto last = static_cast<std::int16_t>(grid.cells - 1);
  for (std::int16_t row = 0; row <= last; ++row) {
    for (std::int16_t col = 0; col <= last; ++col) {
      const auto right = static_cast<std::int16_t>(col + 1);
      const auto below = static_cast<std::int16_t>(row + 1);
      const geo::Vec3 falling = (pointAt(grid, {col, row}) + pointAt(grid, {right, below})) * 0.5;
      const geo::Vec3 rising = (pointAt(grid, {col, below}) + pointAt(grid, {right, row})) * 0.5;
      geo::Vec3 off = (falling - rising) * 0.5;
      if (row == col) off = falling - groundInCell(tiling, ellipsoid, grid, {col, row});
      if (row == last - col) off = rising - groundInCell(tiling, ellipsoid, grid, {col, row});
      const double aside2 =
          std::max(level2(grid, {col, row}, {right, below}), level2(grid, {col, below}, {right, row}));
      errors.worst_m.push_back(std::sqrt(std::min(geo::dot(off, off), aside2)));
    }
  }
  return errors;
}

/// Of each triangle by itself: where it is far off the samples, and where ground between samples bends, are seldom one
/// place.
double errorOf(const std::vector<GridTriangle>& triangles, const SurfaceGrid& grid, const CellErrors& cells,
               double cellSide_m) {
  double worst = 0.0;
  for (const GridTriangle& t : triangles)
    worst = std::max(worst, std::sqrt(TriangleError(grid, t, cellSide_m).worst2()) + cells.under(t));
  return worst;
}

}  // namespace

double meshError_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                   const Triangulation& triangles) {
  const double side_m = cellSide_m(tiling, ellipsoid, grid);
  const CellErrors cells = errorsWithinCells(tiling, ellipsoid, grid);
  double worst = errorOf(triangles.interior, grid, cells, side_m);
  for (const auto& strip : triangles.fine)
    worst = std::max(worst, errorOf(strip, grid, cells, side_m));
  return worst + 2.0 * side_m * side_m / (8.0 * ellipsoid.semiMinorAxis_m());  // the sagitta of a cell's diagonal
}

}  // namespace tellurion::scene
