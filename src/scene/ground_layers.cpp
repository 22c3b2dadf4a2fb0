#include "scene/ground_layers.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tellurion::scene {
namespace {

constexpr double kWildestHeight_m = 1e6;  ///< more is damage, not ground

float believed(float height_m) {
  return std::abs(height_m) <= static_cast<float>(kWildestHeight_m) ? height_m : raster::kNoData;
}

/// A sample of a tile in those of an ancestor, bilinear. NODATA when the nearest is NODATA, else over those that have
/// data. Symmetric in its neighbours to the last bit, so both sides of an edge find the same.
float resampled(const raster::Raster<float>& from, double col, double row) {
  const double baseCol = std::min(std::floor(col), from.width - 2.0);
  const double baseRow = std::min(std::floor(row), from.height - 2.0);
  const double right = col - baseCol;
  const double below = row - baseRow;
  const int c = static_cast<int>(baseCol);
  const int r = static_cast<int>(baseRow);
  if (raster::isNoData(believed(from.at(c + (right > 0.5 ? 1 : 0), r + (below > 0.5 ? 1 : 0))))) return raster::kNoData;
  double sum = 0.0;
  double weights = 0.0;
  const auto add = [&](int dc, int dr) {
    const double weight = (dc != 0 ? right : 1.0 - right) * (dr != 0 ? below : 1.0 - below);
    const float value = believed(from.at(c + dc, r + dr));
    if (weight == 0.0 || raster::isNoData(value)) return;
    sum += weight * static_cast<double>(value);
    weights += weight;
  };
  add(0, 0);
  add(1, 1);
  add(1, 0);
  add(0, 1);
  return static_cast<float>(sum / weights);
}

/// One layer's samples of one tile, from whichever level they may come.
class LayerSampler {
 public:
  LayerSampler(LayerTiles& layer, const tiling::Tiling& tiling, const tiling::TileId& id, int cells)
      : layer_(layer), id_(id), cells_(cells), own_(layer.storedLevel(id)) {
    const auto atLevel = [&](const tiling::TileId& t) { return std::min(own_, layer.storedLevel(t)); };
    if (own_ >= 0) {
      for (std::size_t e = 0; e < 4; ++e)
        edges_[e] = atLevel(tiling.edgeNeighbour(id, tiling::kEdges[e]).tile);
      for (std::size_t k = 0; k < 4; ++k)
        corners_[k] = cornerLevel(tiling, k, atLevel);
    }
    tile_ = fetch(own_);
  }

  const raster::SourceTile* ownTile() const { return own_ == id_.level ? tile_.get() : nullptr; }
  const raster::SourceTile* nearestTile() const { return tile_.get(); }
  int level() const { return own_; }

  /// Sample (col, row), -1..cells + 1.
  float at(int col, int row) {
    const int level = levelFor(col, row);
    if (level == own_) return tile_ ? sample(*tile_, own_, col, row) : raster::kNoData;
    const LayerTiles::TilePointer& tile = coarser(level);
    return tile ? sample(*tile, level, col, row) : raster::kNoData;
  }

 private:
  template <class AtLevel>
  int cornerLevel(const tiling::Tiling& tiling, std::size_t k, const AtLevel& atLevel) const {
    // Corner k lies between edges k - 1 and k: both run clockwise from the top left.
    int level = std::min(edges_[k], edges_[(k + 3) % 4]);
    for (const auto& t : tiling.cornerNeighbours(id_, tiling::kCorners[k]))
      level = std::min(level, atLevel(t));
    return level;
  }

  LayerTiles::TilePointer fetch(int& level) const {
    for (; level >= 0; --level) {
      if (auto tile = layer_.get(id_.ancestor(level))) return tile;
    }
    return nullptr;
  }

  const LayerTiles::TilePointer& coarser(int level) {
    if (level != coarserLevel_) {
      coarserLevel_ = level;
      int from = level;
      coarser_ = fetch(from);
    }
    return coarser_;
  }

  int levelFor(int col, int row) const {
    const bool top = row == 0;
    const bool bottom = row == cells_;
    const bool left = col == 0;
    const bool right = col == cells_;
    if (!(top || bottom || left || right)) return own_;
    if (top && left) return std::min(own_, corners_[0]);
    if (top && right) return std::min(own_, corners_[1]);
    if (bottom && right) return std::min(own_, corners_[2]);
    if (bottom && left) return std::min(own_, corners_[3]);
    return std::min(own_, edges_[top ? 0u : right ? 1u : bottom ? 2u : 3u]);
  }

  float sample(const raster::SourceTile& tile, int level, int col, int row) const {
    const auto& from = std::get<raster::ElevationTile>(tile.payload).samples;
    if (level == id_.level) return believed(from.at(col + 1, row + 1));
    const double scale = tiling::tileSize(id_.level - level);
    const auto local = [&](std::uint32_t index, int i) {
      const std::uint32_t within = index & ((1u << (id_.level - level)) - 1u);
      return (static_cast<double>(within) * cells_ + i) * scale + 1.0;
    };
    return resampled(from, local(id_.x, col), local(id_.y, row));
  }

  LayerTiles& layer_;
  tiling::TileId id_;
  int cells_;
  int own_;
  std::array<int, 4> edges_{-1, -1, -1, -1};
  std::array<int, 4> corners_{-1, -1, -1, -1};
  LayerTiles::TilePointer tile_;
  int coarserLevel_ = -2;
  LayerTiles::TilePointer coarser_;
};

void widen(HeightRange& range, const raster::HeightStatistics& s) {
  if (!(std::isfinite(s.min_m) && std::isfinite(s.max_m) && std::isfinite(s.error_m))) return;
  const double low = static_cast<double>(s.min_m) - static_cast<double>(s.error_m);
  const double high = static_cast<double>(s.max_m) + static_cast<double>(s.error_m);
  range.low_m = std::min(range.low_m, std::max(low, -kWildestHeight_m));
  range.high_m = std::max(range.high_m, std::min(high, kWildestHeight_m));
}

HeightRange rangeOf(const GroundSamples& heights) {
  HeightRange range{.low_m = static_cast<double>(heights.at(1, 1)), .high_m = static_cast<double>(heights.at(1, 1))};
  for (int row = 1; row < heights.height - 1; ++row) {
    const auto inner = heights.row(row).subspan(1, static_cast<std::size_t>(heights.width - 2));
    const auto [low, high] = std::minmax_element(inner.begin(), inner.end());
    range.low_m = std::min(range.low_m, static_cast<double>(*low));
    range.high_m = std::max(range.high_m, static_cast<double>(*high));
  }
  return range;
}

/// What a layer's own tile adds to what is known of the tile and its children.
void addFacts(ComposedGround& ground, const raster::SourceTile& tile) {
  widen(ground.range, tile.statistics);
  for (std::size_t q = 0; q < 4; ++q) {
    if (((tile.childMask >> q) & 1) != 0) widen(ground.childRange[q], tile.children[q]);
  }
  const auto error = static_cast<double>(tile.statistics.error_m);
  if (tile.childMask != 0 && std::isfinite(error)) ground.error_m = std::max(ground.error_m, error);
}

}  // namespace

GroundLayers::GroundLayers(tiling::Tiling tiling, std::vector<std::shared_ptr<LayerTiles>> layers, int cells)
    : tiling_(tiling), layers_(std::move(layers)), cells_(cells) {}

ComposedGround GroundLayers::compose(const tiling::TileId& id) const {
  ComposedGround ground{.heights = GroundSamples(cells_ + 3, cells_ + 3, raster::kNoData)};
  std::vector<std::unique_ptr<LayerSampler>> samplers;
  for (const auto& layer : layers_) {
    samplers.push_back(std::make_unique<LayerSampler>(*layer, tiling_, id, cells_));
    ground.level = std::max(ground.level, samplers.back()->level());
  }
  for (int row = -1; row <= cells_ + 1; ++row) {
    for (int col = -1; col <= cells_ + 1; ++col) {
      float height_m = raster::kNoData;
      for (auto top = samplers.rbegin(); top != samplers.rend() && raster::isNoData(height_m); ++top) {
        height_m = (*top)->at(col, row);
      }
      ground.heights.at(col + 1, row + 1) = raster::isNoData(height_m) ? 0.0f : height_m;
    }
  }
  ground.range = rangeOf(ground.heights);
  ground.childRange.fill(ground.range);
  for (const auto& sampler : samplers) {
    if (sampler->ownTile() != nullptr) addFacts(ground, *sampler->ownTile());
  }
  return ground;
}

}  // namespace tellurion::scene
