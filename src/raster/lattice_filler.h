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
/// and in the gutter, so that neighbours agree there; between, bilinear where that is off by no more than the plane's
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

  /// Of the error allowed, what is allowed where it is measured: in the middle of a cell and of its edges.
  static constexpr double kMeasured = 0.5;
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

  /// A cell with its corners; the gutter is not in it.
  void cell(int left, int top, int right, int bottom) {
    const int middle = (left + right) / 2;
    const int centre = (top + bottom) / 2;
    std::array<Point, 4> corners{exact(left, top), exact(right, top), exact(left, bottom), exact(right, bottom)};
    for (Point& corner : corners)
      corner[0] = near(corner[0], corners[0][0]);
    const auto between = [&](int col, int row) {
      const double s = right > left ? static_cast<double>(col - left) / (right - left) : 0.0;
      const double t = bottom > top ? static_cast<double>(row - top) / (bottom - top) : 0.0;
      Point p{};
      for (std::size_t k = 0; k < kCount; ++k) {
        p[k] = (corners[0][k] * (1.0 - s) + corners[1][k] * s) * (1.0 - t) +
               (corners[2][k] * (1.0 - s) + corners[3][k] * s) * t;
      }
      return p;
    };
    const auto isStraightAt = [&](int col, int row) { return isNear(exact(col, row), between(col, row)); };
    const bool isStraight = isStraightAt(middle, centre) && isStraightAt(middle, top) && isStraightAt(left, centre) &&
                            isStraightAt(middle, bottom) && isStraightAt(right, centre);
    if (!isStraight && (right - left > 2 || bottom - top > 2)) {
      cell(left, top, middle, centre);
      cell(middle, top, right, centre);
      cell(left, centre, middle, bottom);
      cell(middle, centre, right, bottom);
      return;
    }
    for (int row = top; row <= bottom; ++row) {
      for (int col = left; col <= right; ++col) {
        if (known_[index(col, row)]) continue;
        if (isStraight) {
          set(index(col, row), between(col, row));
        } else {
          exact(col, row);
        }
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
