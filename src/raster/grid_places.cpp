#include "raster/grid_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

/// Samples a side of the largest cells of the lattice.
constexpr int kLatticeCell = 16;
/// Of the error allowed, what is allowed where it is measured: in the middle of a cell and of its edges.
constexpr double kMeasured = 0.5;
constexpr int kImageLattice = 16;  ///< cells a side, for what to ask for
constexpr std::size_t kMostImages = 1024;

/// Fills a tile's places from as few exact ones as do.
class LatticeFiller {
 public:
  LatticeFiller(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                int cells, TilePlaces& out)
      : geometry_(geometry),
        tiling_(tiling),
        id_(id),
        kind_(kind),
        cells_(cells),
        side_(sideOf(kind, cells)),
        out_(out),
        known_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), false) {
    out_.plane.resize(known_.size());
    out_.exists.assign(known_.size(), false);
    const GridFit finest = geometry.fit(sampleSpacing(tiling, id.level, cells), tiling.scheme(), 1.0);
    const GridLevel& level = geometry.level(std::max(finest.level, 0));
    xTolerance_ = kMeasured * kPlaceError_pixels * level.pixelWidth;
    yTolerance_ = kMeasured * kPlaceError_pixels * level.pixelHeight;
  }

  /// One after the other, exactly.
  void all() {
    std::vector<std::size_t> indices;
    std::vector<geo::Direction> directions;
    for (int row = 0; row < side_; ++row) {
      for (int column = 0; column < side_; ++column) {
        const auto place = placeOf(tiling_, id_, kind_, cells_, column, row);
        if (!place) continue;
        indices.push_back(index(column, row));
        directions.push_back(*place);
      }
    }
    PlanePlaces exact;
    geometry_.places(directions, exact);
    for (std::size_t i = 0; i < indices.size(); ++i)
      set(indices[i], exact.x[i], exact.y[i], exact.narrowing[i]);
  }

  void lattice() {
    for (int i = 0; i < side_; ++i) {
      exact(i, 0);
      exact(i, side_ - 1);
      exact(0, i);
      exact(side_ - 1, i);
    }
    for (int top = 1; top < side_ - 2; top += kLatticeCell) {
      for (int left = 1; left < side_ - 2; left += kLatticeCell)
        cell(left, top, std::min(left + kLatticeCell, side_ - 2), std::min(top + kLatticeCell, side_ - 2));
    }
  }

 private:
  struct Point {
    double x, y, narrowing;
  };

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) + static_cast<std::size_t>(column);
  }
  void set(std::size_t i, double x, double y, double narrowing) {
    out_.plane.x[i] = x;
    out_.plane.y[i] = y;
    out_.plane.narrowing[i] = narrowing;
    out_.exists[i] = true;
    known_[i] = true;
  }
  Point exact(int column, int row) {
    const std::size_t i = index(column, row);
    if (!known_[i]) {
      known_[i] = true;
      if (const auto place = placeOf(tiling_, id_, kind_, cells_, column, row)) {
        geometry_.places({&*place, 1}, one_);
        set(i, one_.x[0], one_.y[0], one_.narrowing[0]);
      }
    }
    return {out_.plane.x[i], out_.plane.y[i], out_.plane.narrowing[i]};
  }

  /// x at the turn of the plane nearest to another.
  double near(double x, double reference) const {
    return geometry_.turn() > 0.0 ? reference + std::remainder(x - reference, geometry_.turn()) : x;
  }

  /// A cell with its corners; the gutter is not in it.
  void cell(int left, int top, int right, int bottom) {
    const int middle = (left + right) / 2;
    const int centre = (top + bottom) / 2;
    std::array<Point, 4> corners{exact(left, top), exact(right, top), exact(left, bottom), exact(right, bottom)};
    for (Point& corner : corners)
      corner.x = near(corner.x, corners[0].x);
    const auto between = [&](int column, int row) {
      const double s = right > left ? static_cast<double>(column - left) / (right - left) : 0.0;
      const double t = bottom > top ? static_cast<double>(row - top) / (bottom - top) : 0.0;
      const auto mix = [&](double Point::*v) {
        return (corners[0].*v * (1.0 - s) + corners[1].*v * s) * (1.0 - t) +
               (corners[2].*v * (1.0 - s) + corners[3].*v * s) * t;
      };
      return Point{mix(&Point::x), mix(&Point::y), mix(&Point::narrowing)};
    };
    // Written so that what is not finite is not straight.
    const auto isStraightAt = [&](int column, int row) {
      const Point real = exact(column, row);
      const Point guess = between(column, row);
      return std::abs(near(real.x, guess.x) - guess.x) <= xTolerance_ && std::abs(real.y - guess.y) <= yTolerance_;
    };
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
      for (int column = left; column <= right; ++column) {
        const std::size_t i = index(column, row);
        if (known_[i]) continue;
        if (isStraight) {
          const Point p = between(column, row);
          set(i, p.x, p.y, p.narrowing);
        } else {
          exact(column, row);
        }
      }
    }
  }

  const GridGeometry& geometry_;
  const tiling::Tiling& tiling_;
  const tiling::TileId& id_;
  Kind kind_;
  int cells_;
  int side_;
  TilePlaces& out_;
  std::vector<bool> known_;
  PlanePlaces one_;
  double xTolerance_ = 0.0;
  double yTolerance_ = 0.0;
};

/// A range of pixels.
struct Range {
  double low;
  double high;
  void take(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
};

/// Adds the images under parts of a tile to a list, each once.
class ImageCollector {
 public:
  explicit ImageCollector(const GridGeometry& geometry) : geometry_(geometry) {}

  void add(const GridFit& fit, std::span<const GridGeometry::Pixel> corners) {
    const GridWindow& window = geometry_.window(fit.level);
    const GridTopology& grid = window.topology;
    const bool turns = window.period > 0.0;
    Range cols{corners[0].col, corners[0].col};
    Range rows{corners[0].row, corners[0].row};
    for (const auto& corner : corners.subspan(1)) {
      rows.take(corner.row);
      cols.take(turns ? corners[0].col + std::remainder(corner.col - corners[0].col, window.period) : corner.col);
    }
    // Edges bulge between corners.
    const double bulge = 0.02 * std::max(cols.high - cols.low, rows.high - rows.low);
    const double x = 0.5 * std::max(fit.width, 1.0) + bulge + 1.0;
    const double y = 0.5 * std::max(fit.height, 1.0) + bulge + 1.0;
    // Around a pole every column may be met.
    if (turns && cols.high - cols.low > 0.4 * window.period) cols = {0.0, static_cast<double>(grid.width)};
    const bool nearPole = (grid.topPole && rows.low - y < 0.0) || (grid.bottomPole && rows.high + y > grid.height);
    addRect(fit.level, cols.low - x, cols.high + x, rows.low - y, rows.high + y);
    if (nearPole) {
      const double half = 0.5 * grid.ring;
      addRect(fit.level, cols.low - x + half, cols.high + x + half, rows.low - y, rows.high + y);
    }
  }
  std::vector<GridImageId> take() { return std::move(images_); }

 private:
  void addRect(int level, double left, double right, double top, double bottom) {
    const GridWindow& window = geometry_.window(level);
    const GridTopology& grid = window.topology;
    if (!(bottom >= 0.0 && top < grid.height)) return;
    if (grid.ring == 0) {
      if (right >= 0.0 && left < grid.width) addInside(level, left, right, top, bottom);
      return;
    }
    const double shift = std::floor(left / grid.ring) * grid.ring;
    const double from = left - shift;
    const double to = std::min(right - shift, from + grid.ring);
    addInside(level, from, to, top, bottom);
    if (to >= grid.ring) addInside(level, 0.0, to - grid.ring, top, bottom);
  }
  void addInside(int level, double left, double right, double top, double bottom) {
    const GridWindow& window = geometry_.window(level);
    const GridLevel& l = geometry_.level(level);
    const auto index = [](double pixel, int side, int count) {
      return static_cast<int>(std::clamp(std::floor(pixel / side), 0.0, count - 1.0));
    };
    for (int row = index(top, l.imageHeight, window.imageRows); row <= index(bottom, l.imageHeight, window.imageRows);
         ++row) {
      for (int column = index(left, l.imageWidth, window.imageColumns);
           column <= index(right, l.imageWidth, window.imageColumns); ++column) {
        const GridImageId id = geometry_.imageAt(level, column, row);
        if (images_.size() < kMostImages && seen_.insert(id).second) images_.push_back(id);
      }
    }
  }

  const GridGeometry& geometry_;
  std::vector<GridImageId> images_;
  std::unordered_set<GridImageId, GridImageIdHash> seen_;
};

/// Samples of a lattice over a tile, gutter included.
int latticeSample(int i, int side) {
  return i * (side - 1) / kImageLattice;
}

}  // namespace

TilePlaces tilePlaces(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                      int cells) {
  TilePlaces places;
  LatticeFiller filler(geometry, tiling, id, kind, cells, places);
  if (kind == Kind::elevation || cells < kLatticeCell) {
    filler.all();
  } else {
    filler.lattice();
  }
  return places;
}

std::vector<GridImageId> imagesFor(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id,
                                   Kind kind, int cells) {
  constexpr int kNodes = kImageLattice + 1;
  const int side = sideOf(kind, cells);
  const geo::Angle spacing = sampleSpacing(tiling, id.level, cells);
  std::vector<std::size_t> placeAt(kNodes * kNodes, SIZE_MAX);
  std::vector<geo::Direction> directions;
  for (std::size_t i = 0; i < placeAt.size(); ++i) {
    const int column = latticeSample(static_cast<int>(i) % kNodes, side);
    const int row = latticeSample(static_cast<int>(i) / kNodes, side);
    const auto place = placeOf(tiling, id, kind, cells, column, row);
    if (!place) continue;
    placeAt[i] = directions.size();
    directions.push_back(*place);
  }
  PlanePlaces plane;
  geometry.places(directions, plane);

  ImageCollector collector(geometry);
  for (std::size_t row = 0; row < kImageLattice; ++row) {
    for (std::size_t column = 0; column < kImageLattice; ++column) {
      const std::size_t first = row * kNodes + column;
      std::vector<std::size_t> corners;
      for (const std::size_t i : {first, first + 1, first + kNodes, first + kNodes + 1}) {
        const std::size_t p = placeAt[i];
        if (p == SIZE_MAX || !std::isfinite(plane.x[p]) || !std::isfinite(plane.y[p])) continue;
        corners.push_back(p);
      }
      if (corners.empty()) continue;
      for (const std::size_t p : corners) {
        const GridFit fit = geometry.fit(spacing, tiling.scheme(), plane.narrowing[p]);
        if (fit.level < 0) continue;
        std::vector<GridGeometry::Pixel> pixels;
        for (const std::size_t q : corners)
          pixels.push_back(geometry.pixel(fit.level, plane.x[q], plane.y[q]));
        collector.add(fit, pixels);
      }
    }
  }
  return collector.take();
}

}  // namespace tellurion::raster
