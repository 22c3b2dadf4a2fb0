#include "scene/layer_sampler.h"

#include <algorithm>
#include <cmath>
#include <variant>

namespace tellurion::scene {
namespace {

float believed(float height_m) {
  return std::abs(height_m) <= static_cast<float>(kWildestHeight_m) ? height_m : raster::kNoData;
}

/// A sample of a tile in those of an ancestor, bilinear. NODATA when the nearest is NODATA (of several equally near
/// ones: when all are), else over those that have data. The same to the last bit whichever way columns and rows run, so
/// both sides of an edge find the same: no more than two weights are not zero there, and a sum of two is the same
/// either way.
float resampled(const raster::Raster<float>& from, double col, double row) {
  const double baseCol = std::min(std::floor(col), from.width - 2.0);
  const double baseRow = std::min(std::floor(row), from.height - 2.0);
  const double right = col - baseCol;
  const double below = row - baseRow;
  double sum = 0.0;
  double weights = 0.0;
  double nearest = 0.0;
  double nearestWithData = 0.0;
  for (const int dr : {0, 1}) {
    for (const int dc : {0, 1}) {
      const double weight = (dc != 0 ? right : 1.0 - right) * (dr != 0 ? below : 1.0 - below);
      nearest = std::max(nearest, weight);
      const float value = weight > 0.0
                              ? believed(from.at(static_cast<int>(baseCol) + dc, static_cast<int>(baseRow) + dr))
                              : raster::kNoData;
      if (raster::isNoData(value)) continue;
      nearestWithData = std::max(nearestWithData, weight);
      sum += weight * static_cast<double>(value);
      weights += weight;
    }
  }
  return nearestWithData < nearest ? raster::kNoData : static_cast<float>(sum / weights);
}

}  // namespace

Touching touching(const tiling::Tiling& tiling, const tiling::TileId& id) {
  Touching out;
  for (std::size_t k = 0; k < 4; ++k) {
    out.edges[k] = tiling.edgeNeighbour(id, tiling::kEdges[k]).tile;
    out.corners[k] = tiling.cornerNeighbour(id, tiling::kCorners[k]);
  }
  return out;
}

LayerSampler::LayerSampler(const GroundLayers::Layer& layer, const tiling::Tiling& tiling, const tiling::TileId& id,
                           const Touching& others, int cells, const raster::Seam* seam)
    : tiles_(*layer.tiles),
      tiling_(tiling),
      seam_(seam),
      id_(id),
      cells_(cells),
      levels_(id, others, cells, [&](const tiling::TileId& t) { return layer.storedLevel(t); }),
      own_(levels_.own()) {
  tile_ = fetch(own_);
}

double LayerSampler::weightAt(int col, int row) const {
  if (seam_ == nullptr) return 1.0;
  const auto place =
      tiling_.wrapped(tiling::rootPointIn(id_, static_cast<double>(col) / cells_, static_cast<double>(row) / cells_));
  return place ? seam_->weight(tiling_.direction(*place)) : 1.0;
}

float LayerSampler::at(int col, int row) {
  const int level = std::min(own_, levels_.at(col, row));
  if (level == own_) return tile_ ? sample(*tile_, own_, col, row) : raster::kNoData;
  const LayerTiles::TilePointer& tile = coarser(level);
  return tile ? sample(*tile, level, col, row) : raster::kNoData;
}

LayerTiles::TilePointer LayerSampler::fetch(int& level) const {
  for (; level >= 0; --level) {
    if (auto tile = tiles_.held(id_.ancestor(level))) return tile;
  }
  return nullptr;
}

const LayerTiles::TilePointer& LayerSampler::coarser(int level) {
  if (level != coarserLevel_) {
    coarserLevel_ = level;
    int from = level;
    coarser_ = fetch(from);
  }
  return coarser_;
}

float LayerSampler::sample(const raster::SourceTile& tile, int level, int col, int row) const {
  const auto& from = std::get<raster::ElevationTile>(tile.payload).samples;
  if (level == id_.level) return believed(from.at(col + 1, row + 1));
  const double scale = tiling::tileSize(id_.level - level);
  const auto local = [&](std::uint32_t index, int i) {
    const std::uint32_t within = index & ((1u << (id_.level - level)) - 1u);
    return (static_cast<double>(within) * cells_ + i) * scale + 1.0;
  };
  return resampled(from, local(id_.x, col), local(id_.y, row));
}

}  // namespace tellurion::scene
