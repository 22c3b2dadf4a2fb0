#include "pyramid/base_layer.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "pyramid/sample_views.h"
#include "raster/bilinear.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

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

float heightAt(const Raster<float>& tile, const Position& position) {
  const Corners c = cornersAt(position, tile.width);
  const auto corner = [&](int i) { return static_cast<double>(tile.at(c.column + (i & 1), c.row + (i >> 1))); };
  const auto height = raster::bilinearHeight({corner(0), corner(1), corner(2), corner(3)}, c.right, c.bottom);
  return height ? static_cast<float>(*height) : kNoData;
}

template <class T>
T nearestSample(const Raster<T>& tile, const Position& position) {
  const int last = tile.width - 1;
  return tile.at(std::clamp(static_cast<int>(std::lround(position.column)), 0, last),
                 std::clamp(static_cast<int>(std::lround(position.row)), 0, last));
}

}  // namespace

struct BaseLayer::Found {
  raster::SourceTile tile;
  tiling::TileId id;
  std::optional<Raster<float>> depths = {};
};

io::Result<std::optional<BaseLayer::Found>> BaseLayer::nearest(const tiling::TileId& id) const {
  for (int level = id.level; level >= 0; --level) {
    const tiling::TileId ancestor = id.ancestor(level);
    auto tile = reader_->load(ancestor);
    if (!tile) return tl::unexpected(tile.error());
    if (!*tile) continue;
    auto depths = reader_->depths(ancestor);
    if (!depths) return tl::unexpected(depths.error());
    return std::optional(Found{std::move(**tile), ancestor, std::move(*depths)});
  }
  return std::optional<Found>{};
}

/// The heights of one tile's places, with the tiles around it that are needed.
class BaseLayer::Heights {
 public:
  explicit Heights(const BaseLayer& base)
      : base_(base), tiling_(base.reader_->info().scheme), cells_(base.reader_->info().tileCells) {}

  struct Sample {
    float height_m = kNoData;
    std::int8_t depth = -1;
  };
  /// Of all views of the place, the one whose stored tile is finest.
  Sample at(const SampleView& sample) {
    const Found* best = nullptr;
    const SampleView* bestView = nullptr;
    const std::vector<SampleView> views = viewsOf(tiling_, sample, cells_);
    for (const SampleView& view : views) {
      const std::optional<Found>& found = nearestTo(view.tile);
      if (!found || (best != nullptr && best->id.level >= found->id.level)) continue;
      best = &*found;
      bestView = &view;
    }
    if (best == nullptr) return {};
    const Raster<float>& stored = std::get<raster::ElevationTile>(best->tile.payload).samples;
    const Position position =
        inAncestor(bestView->tile, best->id, cells_, 0.0, bestView->column + kGutter, bestView->row + kGutter);
    const float height_m = heightAt(stored, position);
    if (raster::isNoData(height_m)) return {};
    const float coarser = best->depths ? nearestSample(*best->depths, position) : kNoData;
    return {height_m,
            raster::isNoData(coarser) ? static_cast<std::int8_t>(best->id.level) : static_cast<std::int8_t>(coarser)};
  }

  Ground ofTile(const tiling::TileId& id) {
    const int side = sideOf(raster::Kind::elevation, cells_);
    Ground ground{.heights = Raster<float>(side, side, kNoData), .depths = {}};
    ground.depths.resize(ground.heights.samples.size(), -1);
    const auto put = [&](int column, int row, const Sample& sample) {
      ground.heights.at(column, row) = sample.height_m;
      ground.depths[static_cast<std::size_t>(row * side + column)] = sample.depth;
    };
    for (int row = 0; row <= cells_; ++row) {
      for (int column = 0; column <= cells_; ++column) {
        put(column + kGutter, row + kGutter, at({id, column, row}));
      }
    }
    for (int i = 0; i <= cells_; ++i) {
      const int place = i + kGutter;
      put(place, 0, at(viewAcross(tiling_, id, tiling::Edge::top, i, 1, cells_)));
      put(side - 1, place, at(viewAcross(tiling_, id, tiling::Edge::right, i, 1, cells_)));
      put(place, side - 1, at(viewAcross(tiling_, id, tiling::Edge::bottom, i, 1, cells_)));
      put(0, place, at(viewAcross(tiling_, id, tiling::Edge::left, i, 1, cells_)));
    }
    return ground;
  }

  const std::optional<io::Failure>& failure() const { return failure_; }

 private:
  const std::optional<Found>& nearestTo(const tiling::TileId& id) {
    const auto known = found_.find(id);
    if (known != found_.end()) return known->second;
    auto found = base_.nearest(id);
    if (!found) failure_ = found.error();
    return found_.emplace(id, found ? std::move(*found) : std::nullopt).first->second;
  }

  const BaseLayer& base_;
  tiling::Tiling tiling_;
  int cells_;
  std::unordered_map<tiling::TileId, std::optional<Found>, tiling::TileIdHash> found_;
  std::optional<io::Failure> failure_;
};

io::Result<BaseLayer::Ground> BaseLayer::heights(const tiling::TileId& id) const {
  Heights heights(*this);
  Ground ground = heights.ofTile(id);
  if (heights.failure()) return tl::unexpected(*heights.failure());
  return ground;
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
      colours.at(column, row) = nearestSample(stored, inAncestor(id, (*found)->id, size, 0.5, column, row));
    }
  }
  return colours;
}

}  // namespace tellurion::pyramid
