#include "raster/height_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "raster/bilinear.h"
#include "raster/tile_places.h"

namespace tellurion::raster {
namespace {

constexpr double kNone = static_cast<double>(kNoData);

/// A place between columns or rows of a lattice of `count`.
struct Between {
  int index = 0;       ///< of the one before it, so that there is one after it
  double share = 0.0;  ///< of the way to that
};

Between between(double at, int count) {
  const int index = std::clamp(static_cast<int>(std::floor(at)), 0, count - 2);
  return {.index = index, .share = at - index};
}

std::optional<double> heightAt(const Raster<float>& heights, double column, double row) {
  const Between c = between(column, heights.width);
  const Between r = between(row, heights.height);
  const auto at = [&](int dc, int dr) { return static_cast<double>(heights.at(c.index + dc, r.index + dr)); };
  return bilinearHeight({at(0, 0), at(1, 0), at(0, 1), at(1, 1)}, c.share, r.share);
}

/// Where the samples lie on the ellipsoid; NaN where no single place owns one.
Raster<geo::Vec3> positionsOf(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                              int cells) {
  const int side = sideOf(Kind::elevation, cells);
  Raster<geo::Vec3> out(side, side, geo::Vec3(kNone));
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const auto place = placeOf(tiling, id, Kind::elevation, cells, column, row);
      if (place) out.at(column, row) = ellipsoid.bodyFromDirection(*place).m;
    }
  }
  return out;
}

/// The vector in the plane of two others along which a number rises by these amounts along each.
geo::Vec3 gradientOf(const geo::Vec3& across, const geo::Vec3& down, double riseAcross, double riseDown) {
  const geo::Vec3 normal = geo::cross(across, down);
  return (riseAcross * geo::cross(down, normal) + riseDown * geo::cross(normal, across)) / geo::dot(normal, normal);
}

}  // namespace

HeightBlock::HeightBlock(const tiling::Tiling& tiling, const geo::Ellipsoid& ellipsoid, const tiling::TileId& id,
                         Raster<float> heights)
    : heights_(std::move(heights)), gradients_(heights_.width - 1, heights_.height - 1) {
  // Who makes a tile promises nothing of its gutter's corners.
  const int last = heights_.width - 1;
  for (const int row : {0, last}) {
    for (const int column : {0, last})
      heights_.at(column, row) = kNoData;
  }
  const Raster<geo::Vec3> positions = positionsOf(tiling, ellipsoid, id, cells());
  for (int row = 0; row < gradients_.height; ++row) {
    for (int column = 0; column < gradients_.width; ++column) {
      const auto h = [&](int dc, int dr) { return static_cast<double>(heights_.at(column + dc, row + dr)); };
      const auto p = [&](int dc, int dr) { return positions.at(column + dc, row + dr); };
      gradients_.at(column, row) =
          gradientOf(p(1, 0) - p(0, 0) + p(1, 1) - p(0, 1), p(0, 1) - p(0, 0) + p(1, 1) - p(1, 0),
                     h(1, 0) - h(0, 0) + h(1, 1) - h(0, 1), h(0, 1) - h(0, 0) + h(1, 1) - h(1, 0));
    }
  }
}

std::optional<double> HeightBlock::height_m(double column, double row) const {
  return heightAt(heights_, column + kGutter, row + kGutter);
}

std::optional<geo::Vec3> HeightBlock::gradient(double column, double row) const {
  const Between c = between(column + kGutter - 0.5, gradients_.width);
  const Between r = between(row + kGutter - 0.5, gradients_.height);
  const auto known = [&](int dc, int dr) { return !std::isnan(gradients_.at(c.index + dc, r.index + dr).x); };
  if (!known(c.share < 0.5 ? 0 : 1, r.share < 0.5 ? 0 : 1)) return std::nullopt;
  geo::Vec3 sum(0.0);
  double weights = 0.0;
  for (const int dr : {0, 1}) {
    for (const int dc : {0, 1}) {
      const double weight = (dc != 0 ? c.share : 1.0 - c.share) * (dr != 0 ? r.share : 1.0 - r.share);
      if (weight == 0.0 || !known(dc, dr)) continue;
      sum += weight * gradients_.at(c.index + dc, r.index + dr);
      weights += weight;
    }
  }
  return sum / weights;
}

Raster<float> enlargedHeights(const Raster<float>& heights, const tiling::TileId& id, const tiling::TileId& below) {
  Raster<float> out(heights.width, heights.height, kNoData);
  const int cells = heights.width - 1 - 2 * kGutter;
  const double scale = tiling::tileSize(below.level - id.level);
  const auto place = [&](std::uint32_t index, int i) {
    const std::uint32_t within = index & ((1u << (below.level - id.level)) - 1u);
    return (static_cast<double>(within) * cells + i - kGutter) * scale + kGutter;
  };
  for (int row = 0; row < out.height; ++row) {
    for (int column = 0; column < out.width; ++column) {
      const auto height = heightAt(heights, place(below.x, column), place(below.y, row));
      if (height) out.at(column, row) = static_cast<float>(*height);
    }
  }
  return out;
}

}  // namespace tellurion::raster
