#include "pyramid/base_layer.h"

#include <algorithm>
#include <cmath>

#include "pyramid/tile_places.h"
#include "raster/reduce.h"

namespace tellurion::pyramid {
namespace {

using raster::isNoData;
using raster::kGutter;
using raster::kNoData;
using raster::Raster;
using raster::Rgba8;

/// Where a sample of a tile lies among an ancestor's samples, gutter included.
struct Position {
  double column;
  double row;
};

/// shift: where the first sample of a tile itself lies, in samples from the tile's border: 0 or one half.
Position inAncestor(const tiling::TileId& id, const tiling::TileId& ancestor, int cells, double shift, int column,
                    int row) {
  const unsigned levels = static_cast<unsigned>(id.level - ancestor.level);
  const double scale = 1.0 / static_cast<double>(std::uint64_t{1} << levels);
  const double x0 = static_cast<double>(id.x - (ancestor.x << levels)) * cells;
  const double y0 = static_cast<double>(id.y - (ancestor.y << levels)) * cells;
  return {(x0 + column - kGutter + shift) * scale - shift + kGutter,
          (y0 + row - kGutter + shift) * scale - shift + kGutter};
}

/// The four samples around a position and their weights.
struct Corners {
  int column;
  int row;
  double right;
  double bottom;
};

Corners cornersAt(const Position& position, int side) {
  const int column = std::clamp(static_cast<int>(std::floor(position.column)), 0, side - 2);
  const int row = std::clamp(static_cast<int>(std::floor(position.row)), 0, side - 2);
  return {column, row, position.column - column, position.row - row};
}

/// Bilinear; NODATA where the nearest sample is, else over those that have data.
float heightAt(const Raster<float>& tile, const Position& position) {
  const Corners c = cornersAt(position, tile.width);
  const float nearest = tile.at(c.column + (c.right >= 0.5 ? 1 : 0), c.row + (c.bottom >= 0.5 ? 1 : 0));
  if (isNoData(nearest)) return kNoData;
  double sum = 0.0;
  double weights = 0.0;
  for (int i = 0; i < 4; ++i) {
    const float height = tile.at(c.column + (i & 1), c.row + (i >> 1));
    const double weight = ((i & 1) != 0 ? c.right : 1.0 - c.right) * ((i >> 1) != 0 ? c.bottom : 1.0 - c.bottom);
    if (weight == 0.0 || isNoData(height)) continue;
    sum += weight * static_cast<double>(height);
    weights += weight;
  }
  return static_cast<float>(sum / weights);
}

Rgba8 nearestColour(const Raster<Rgba8>& tile, const Position& position) {
  const int last = tile.width - 1;
  return tile.at(std::clamp(static_cast<int>(std::lround(position.column)), 0, last),
                 std::clamp(static_cast<int>(std::lround(position.row)), 0, last));
}

}  // namespace

io::Result<std::optional<BaseLayer::Found>> BaseLayer::nearest(const tiling::TileId& id) const {
  for (int level = id.level; level >= 0; --level) {
    const tiling::TileId ancestor = id.ancestor(level);
    auto tile = reader_->load(ancestor);
    if (!tile) return tl::unexpected(tile.error());
    if (*tile) return std::optional(Found{std::move(**tile), ancestor});
  }
  return std::optional<Found>{};
}

io::Result<Raster<float>> BaseLayer::heights(const tiling::TileId& id) const {
  const int cells = reader_->info().tileCells;
  const int side = sideOf(raster::Kind::elevation, cells);
  Raster<float> heights(side, side, kNoData);
  auto found = nearest(id);
  if (!found) return tl::unexpected(found.error());
  if (!*found) return heights;
  const Raster<float>& stored = std::get<raster::ElevationTile>((*found)->tile.payload).samples;
  if ((*found)->id == id) return stored;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      heights.at(column, row) = heightAt(stored, inAncestor(id, (*found)->id, cells, 0.0, column, row));
    }
  }
  return heights;
}

io::Result<Raster<Rgba8>> BaseLayer::colours(const tiling::TileId& id) const {
  const int size = reader_->info().tileCells;
  const int side = sideOf(raster::Kind::imagery, size);
  Raster<Rgba8> colours(side, side);
  auto found = nearest(id);
  if (!found) return tl::unexpected(found.error());
  if (!*found) return colours;
  const Raster<Rgba8>& stored = std::get<raster::ImageryTile>((*found)->tile.payload).pixels;
  if ((*found)->id == id) return stored;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      colours.at(column, row) = nearestColour(stored, inAncestor(id, (*found)->id, size, 0.5, column, row));
    }
  }
  return colours;
}

}  // namespace tellurion::pyramid
