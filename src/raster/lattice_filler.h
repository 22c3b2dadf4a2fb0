#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "raster/tile_places.h"

namespace tellurion::raster {

/// Fills the places of a tile's samples in a plane, gutter included, from as few exact ones as do: exactly on a lattice
/// and in the gutter, so that neighbours agree there; between, quadratic where that is off by no more than the plane's
/// tolerance. Plane has
///   Places               columns of numbers, one for each sample
///   kColumns             pointers to them: x and y first, then what varies smoothly with them
///   void exact(std::span<const geo::Direction>, Places&) const    not finite where the plane has no such place
///   double turn() const  x after which the plane begins again; 0: never
///   double xTolerance() const, yTolerance() const
template <class Plane>
class LatticeFiller {
 public:
  using Places = typename Plane::Places;

  /// Samples a side of the largest cells of the lattice.
  static constexpr int kCell = 16;

  LatticeFiller(const Plane& plane, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind, int cells)
      : plane_(plane),
        tiling_(tiling),
        id_(id),
        kind_(kind),
        cells_(cells),
        side_(sideOf(kind, cells)),
        known_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), false) {}

  /// Row by row; not finite at corners of the gutter that no single place owns.
  void fill(Places& out) {
    prepare(out);
    for (int i = 0; i < side_; ++i) {
      exact(i, 0);
      exact(i, side_ - 1);
      exact(0, i);
      exact(side_ - 1, i);
    }
    for (int top = 1; top < side_ - 2; top += kCell) {
      for (int left = 1; left < side_ - 2; left += kCell)
        cell(left, top, std::min(left + kCell, side_ - 2), std::min(top + kCell, side_ - 2));
    }
  }

  /// The same, each exactly.
  void fillExactly(Places& out) {
    prepare(out);
    std::vector<std::size_t> indices;
    std::vector<geo::Direction> directions;
    for (int row = 0; row < side_; ++row) {
      for (int col = 0; col < side_; ++col) {
        const auto place = placeOf(tiling_, id_, kind_, cells_, col, row);
        if (!place) continue;
        indices.push_back(index(col, row));
        directions.push_back(*place);
      }
    }
    plane_.exact(directions, one_);
    for (std::size_t i = 0; i < indices.size(); ++i)
      set(indices[i], pointOf(one_, i));
  }

 private:
  static constexpr std::size_t kCount = Plane::kColumns.size();
  using Point = std::array<double, kCount>;

  /// Of the error allowed, what is allowed where it is measured. Planes have kinks (where the parts of a tiling or of a
  /// map meet); one that cuts off a corner of a cell is seven times worse beside that corner than where it is measured.
  static constexpr double kMeasured = 1.0 / 7.0;
  /// Sides of the smallest cells; a smaller one saves nothing.
  static constexpr int kLeast = 4;
  /// By how much, as a share, what varies smoothly may be off there.
  static constexpr double kOther = 0.01;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column);
  }
  static Point pointOf(const Places& places, std::size_t i) {
    Point p{};
    for (std::size_t k = 0; k < kCount; ++k)
      p[k] = (places.*Plane::kColumns[k])[i];
    return p;
  }
  void prepare(Places& out) {
    out_ = &out;
    for (const auto& column : Plane::kColumns)
      (out.*column).assign(known_.size(), std::numeric_limits<double>::quiet_NaN());
  }
  void set(std::size_t i, const Point& p) {
    for (std::size_t k = 0; k < kCount; ++k)
      ((*out_).*Plane::kColumns[k])[i] = p[k];
    known_[i] = true;
  }
  Point exact(int col, int row) {
    const std::size_t i = index(col, row);
    if (!known_[i]) {
      known_[i] = true;
      if (const auto place = placeOf(tiling_, id_, kind_, cells_, col, row)) {
        plane_.exact({&*place, 1}, one_);
        set(i, pointOf(one_, 0));
      }
    }
    return pointOf(*out_, i);
  }

  /// x at the turn of the plane nearest to another.
  double near(double x, double reference) const {
    return plane_.turn() > 0.0 ? reference + std::remainder(x - reference, plane_.turn()) : x;
  }

  /// Written so that what is not finite is not near.
  bool isNear(const Point& real, const Point& guess) const {
    bool isOther = true;
    for (std::size_t k = 2; k < kCount; ++k)
      isOther = isOther && std::abs(real[k] - guess[k]) <= kOther * std::abs(real[k]);
    return isOther && std::abs(near(real[0], guess[0]) - guess[0]) <= kMeasured * plane_.xTolerance() &&
           std::abs(real[1] - guess[1]) <= kMeasured * plane_.yTolerance();
  }

  /// A quadratic through three points: weights at u, of nodes at 0, m and 1.
  static std::array<double, 3> weights(double u, double m) {
    return {(u - m) * (u - 1.0) / m, u * (u - 1.0) / (m * (m - 1.0)), u * (u - m) / (1.0 - m)};
  }
  static Point mixed(const std::array<Point, 3>& nodes, const std::array<double, 3>& w) {
    Point p{};
    for (std::size_t k = 0; k < kCount; ++k)
      p[k] = nodes[0][k] * w[0] + nodes[1][k] * w[1] + nodes[2][k] * w[2];
    return p;
  }

  /// The samples from (left, top) to (right, bottom), the gutter not among them: between three times three of them
  /// quadratic both ways, if that is right at four more.
  void cell(int left, int top, int right, int bottom) {
    if (right - left < kLeast || bottom - top < kLeast) {
      for (int row = top; row <= bottom; ++row) {
        for (int col = left; col <= right; ++col)
          exact(col, row);
      }
      return;
    }
    const int middle = (left + right) / 2;
    const int centre = (top + bottom) / 2;
    const std::array cols{left, middle, right};
    const std::array rows{top, centre, bottom};
    std::array<std::array<Point, 3>, 3> nodes{};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        nodes[r][c] = exact(cols[c], rows[r]);
        nodes[r][c][0] = near(nodes[r][c][0], nodes[0][0][0]);
      }
    }
    const auto across = [&](int col) {
      return weights(static_cast<double>(col - left) / (right - left),
                     static_cast<double>(middle - left) / (right - left));
    };
    const auto lineAt = [&](int row) {
      const auto w =
          weights(static_cast<double>(row - top) / (bottom - top), static_cast<double>(centre - top) / (bottom - top));
      std::array<Point, 3> line{};
      for (std::size_t c = 0; c < 3; ++c)
        line[c] = mixed({nodes[0][c], nodes[1][c], nodes[2][c]}, w);
      return line;
    };
    const auto isRightAt = [&](int col, int row) { return isNear(exact(col, row), mixed(lineAt(row), across(col))); };
    const int first = (left + middle) / 2;
    const int third = (middle + right) / 2;
    const int upper = (top + centre) / 2;
    const int lower = (centre + bottom) / 2;
    if (!(isRightAt(first, upper) && isRightAt(third, upper) && isRightAt(first, lower) && isRightAt(third, lower))) {
      cell(left, top, middle, centre);
      cell(middle, top, right, centre);
      cell(left, centre, middle, bottom);
      cell(middle, centre, right, bottom);
      return;
    }
    std::array<std::array<double, 3>, kCell + 1> columns{};
    for (int col = left; col <= right; ++col)
      columns[static_cast<std::size_t>(col - left)] = across(col);
    for (int row = top; row <= bottom; ++row) {
      const std::array<Point, 3> line = lineAt(row);
      for (int col = left; col <= right; ++col) {
        const std::size_t i = index(col, row);
        if (!known_[i]) set(i, mixed(line, columns[static_cast<std::size_t>(col - left)]));
      }
    }
  }

  const Plane& plane_;
  const tiling::Tiling& tiling_;
  const tiling::TileId& id_;
  Kind kind_;
  int cells_;
  int side_;
  Places* out_ = nullptr;
  std::vector<bool> known_;
  Places one_;
};

}  // namespace tellurion::raster
