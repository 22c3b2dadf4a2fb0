#include "raster/grid_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_set>

#include "raster/lattice_filler.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

constexpr int kImageLattice = 16;  ///< cells a side, for what to ask for
constexpr std::size_t kMostImages = 1024;

/// A grid's plane as a tile sees it.
class GridPlane {
 public:
  using Places = PlanePlaces;
  static constexpr std::array kColumns{&PlanePlaces::x, &PlanePlaces::y, &PlanePlaces::narrowing};

  GridPlane(const GridGeometry& geometry, const tiling::Tiling& tiling, int level, int cells) : geometry_(geometry) {
    const GridFit finest = geometry.fit(sampleSpacing(tiling, level, cells), tiling.scheme(), 1.0);
    const GridLevel& read = geometry.level(std::max(finest.level, 0));
    xTolerance_ = kPlaceError_pixels * read.pixelWidth;
    yTolerance_ = kPlaceError_pixels * read.pixelHeight;
  }
  void exact(std::span<const geo::Direction> directions, PlanePlaces& out) const { geometry_.places(directions, out); }
  double turn() const { return geometry_.turn(); }
  double xTolerance() const { return xTolerance_; }
  double yTolerance() const { return yTolerance_; }

 private:
  const GridGeometry& geometry_;
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

PlanePlaces tilePlaces(const GridGeometry& geometry, const tiling::Tiling& tiling, const tiling::TileId& id, Kind kind,
                       int cells) {
  PlanePlaces places;
  const GridPlane plane(geometry, tiling, id.level, cells);
  LatticeFiller filler(plane, tiling, id, kind, cells);
  if (kind == Kind::elevation || cells < filler.kCell) {
    filler.fillExactly(places);
  } else {
    filler.fill(places);
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
