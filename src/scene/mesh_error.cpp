#include "scene/mesh_error.h"

#include <algorithm>
#include <cmath>
#include <tuple>

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

double errorOf(const std::vector<GridTriangle>& triangles, const SurfaceGrid& grid, double cellSide_m) {
  double worst2 = 0.0;
  for (const GridTriangle& t : triangles)
    worst2 = std::max(worst2, TriangleError(grid, t, cellSide_m).worst2());
  return std::sqrt(worst2);
}

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

/// How far the bilinear ground between four samples is from the triangles between them, at most, curvature included: at
/// the middle of the cell, against either diagonal. On the tile's diagonals, which no triangle crosses, against the
/// diagonal itself: the map may have a crease there, and then so has the mesh. In a cliff that is far up or down, but
/// both surfaces pass through every height between the corners' somewhere in the cell: no further aside than the cell
/// is wide.
double errorWithinCells(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid) {
  double worst2 = 0.0;
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
      worst2 = std::max(worst2, std::min(geo::dot(off, off), aside2));
    }
  }
  const double diagonal_m = std::sqrt(2.0) * cellSide_m(tiling, ellipsoid, grid);
  return std::sqrt(worst2) + diagonal_m * diagonal_m / (8.0 * ellipsoid.semiMinorAxis_m());
}

}  // namespace

double meshError_m(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const SurfaceGrid& grid,
                   const Triangulation& triangles) {
  const double side_m = cellSide_m(tiling, ellipsoid, grid);
  double worst = errorOf(triangles.interior, grid, side_m);
  for (const auto& strip : triangles.fine)
    worst = std::max(worst, errorOf(strip, grid, side_m));
  return worst + errorWithinCells(tiling, ellipsoid, grid);
}

}  // namespace tellurion::scene
