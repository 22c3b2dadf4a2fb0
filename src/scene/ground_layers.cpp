#include "scene/ground_layers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene/layer_sampler.h"

namespace tellurion::scene {
namespace {

void widen(HeightRange& range, const raster::HeightStatistics& s) {
  if (!(std::isfinite(s.min_m) && std::isfinite(s.max_m) && std::isfinite(s.error_m))) return;
  const double low = static_cast<double>(s.min_m) - static_cast<double>(s.error_m);
  const double high = static_cast<double>(s.max_m) + static_cast<double>(s.error_m);
  range.low_m = std::min(range.low_m, std::max(low, -kWildestHeight_m));
  range.high_m = std::max(range.high_m, std::min(high, kWildestHeight_m));
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

/// A sample of a tile out of its parent's composed ground: its own, or half-way between them.
float betweenParents(const GroundSamples& parent, const tiling::TileId& id, int cells, int col, int row) {
  const int twiceCol = static_cast<int>(id.x & 1u) * cells + col + 2;
  const int twiceRow = static_cast<int>(id.y & 1u) * cells + row + 2;
  const auto at = [&](int dc, int dr) {
    return static_cast<double>(parent.at((twiceCol + dc) / 2, (twiceRow + dr) / 2));
  };
  return static_cast<float>(((at(0, 0) + at(1, 1)) + (at(1, 0) + at(0, 1))) * 0.25);
}

using Samplers = std::vector<std::unique_ptr<LayerSampler>>;

/// The height of the uppermost layer that has data; where that has a seam, between it and the layers below.
float composedAt(const Samplers& samplers, int col, int row) {
  double sum = 0.0;
  double rest = 1.0;
  float lowest_m = raster::kNoData;
  for (auto top = samplers.rbegin(); top != samplers.rend(); ++top) {
    const float height_m = (*top)->at(col, row);
    if (raster::isNoData(height_m)) continue;
    const double weight = (*top)->weightAt(col, row);
    if (weight >= 1.0 && rest >= 1.0) return height_m;
    lowest_m = height_m;
    if (weight >= 1.0) break;
    sum += rest * weight * static_cast<double>(height_m);
    rest *= 1.0 - weight;
  }
  // The lowest that has data takes all that is left.
  return raster::isNoData(lowest_m) ? lowest_m : static_cast<float>(sum + rest * static_cast<double>(lowest_m));
}

void unite(HeightRange& range, double height_m) {
  range = {.low_m = std::min(range.low_m, height_m), .high_m = std::max(range.high_m, height_m)};
}

void unite(HeightRange& range, const HeightRange& other) {
  unite(range, other.low_m);
  unite(range, other.high_m);
}

/// A quarter of a tile: samples firstCol..firstCol + half, likewise rows.
struct Quarter {
  std::size_t quadrant = 0;
  int firstCol = 0;
  int firstRow = 0;
  int half = 0;
};

Quarter quarterOf(int quadrant, int cells) {
  const int half = cells / 2;
  return {.quadrant = static_cast<std::size_t>(quadrant),
          .firstCol = (quadrant & 1) * half,
          .firstRow = (quadrant >> 1) * half,
          .half = half};
}

template <class Visit>
void forEachSample(const Quarter& q, const Visit& visit) {
  for (int row = q.firstRow; row <= q.firstRow + q.half; ++row) {
    for (int col = q.firstCol; col <= q.firstCol + q.half; ++col)
      visit(col, row);
  }
}

bool hasChild(const LayerSampler& sampler, const Quarter& q) {
  return sampler.ownTile() != nullptr && ((sampler.ownTile()->childMask >> q.quadrant) & 1) != 0;
}

/// The mean of what has data next to a sample without, if anything has. On an edge only what lies on it counts, which
/// both tiles there know; samples of the parent, and gutters, have NODATA and take the parent's.
float besideGap(const Samplers& samplers, int cells, int level, int col, int row) {
  const auto edge = [&](int i) { return i == 0 || i == cells; };
  if (col < 0 || row < 0 || col > cells || row > cells || (edge(col) && edge(row))) return raster::kNoData;
  if (level > 0 && col % 2 == 0 && row % 2 == 0) return raster::kNoData;
  double sum = 0.0;
  int count = 0;
  // A sum of two is the same whichever way an edge runs.
  const auto add = [&](int c, int r) {
    const float height_m = composedAt(samplers, c, r);
    if (raster::isNoData(height_m)) return;
    sum += static_cast<double>(height_m);
    ++count;
  };
  if (!edge(row)) {
    add(col, row - 1);
    add(col, row + 1);
  }
  if (!edge(col)) {
    add(col - 1, row);
    add(col + 1, row);
  }
  return count > 0 ? static_cast<float>(sum / count) : raster::kNoData;
}

/// Whether something else than at this level's samples may come through where layers have gaps in a quarter, on the
/// deeper levels that some layer has there. From the top down to the first layer without a gap.
bool hasGaps(const Samplers& samplers, const Quarter& q) {
  const bool finer =
      std::any_of(samplers.begin(), samplers.end(), [&](const auto& sampler) { return hasChild(*sampler, q); });
  for (auto top = samplers.rbegin(); finer && top != samplers.rend(); ++top) {
    bool some = false;
    bool all = true;
    forEachSample(q, [&](int col, int row) {
      const bool hasData = !raster::isNoData((*top)->at(col, row));
      some = some || hasData;
      all = all && hasData;
    });
    if (all && (*top)->seam() == nullptr) return false;
    if (some || hasChild(**top, q)) return true;
  }
  return false;
}

/// The sources' errors are of their own data alone. Where a layer has gaps, deeper tiles may move its border by as much
/// as a cell, and fill the gap otherwise: so the ground of that quarter is off by up to the whole height from one side
/// of it to the other, measured upwards. But all levels pass through this one's samples, and in between through all
/// heights between theirs (or past them by no more than the sources' errors), so in space it is no further than two
/// cells aside and that.
void addGaps(ComposedGround& ground, const Samplers& samplers, int cells, double spacing_m) {
  const double inSpace_m = std::hypot(2.0 * std::numbers::sqrt2 * spacing_m, ground.error_m);
  double error_m = ground.error_m;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const Quarter q = quarterOf(quadrant, cells);
    if (!hasGaps(samplers, q)) continue;
    HeightRange& range = ground.childRange[q.quadrant];
    for (const auto& sampler : samplers) {
      forEachSample(q, [&](int col, int row) {
        const float height_m = sampler->at(col, row);
        if (!raster::isNoData(height_m)) unite(range, static_cast<double>(height_m));
      });
    }
    unite(ground.range, range);
    error_m = std::max(error_m, std::min(range.high_m - range.low_m, inSpace_m));
  }
  ground.error_m = error_m;
}

/// Between samples a seam is not the mean of those around: the weight is bent there, by its second derivative of at
/// most 6 / width^2, and where weight and heights change within a cell their product is bent too. Only of ground with
/// finer data below.
double seamError_m(const Samplers& samplers, std::size_t layer, int cells, double spacing_m) {
  const LayerSampler& sampler = *samplers[layer];
  /// From what lies below to the layer, where the seam is; NODATA elsewhere.
  const auto wayUp_m = [&](int col, int row) {
    const double weight = sampler.weightAt(col, row);
    if (weight <= 0.0 || weight >= 1.0) return raster::kNoData;
    float under_m = raster::kNoData;
    for (std::size_t i = layer; raster::isNoData(under_m) && i-- > 0;)
      under_m = samplers[i]->at(col, row);
    return samplers[layer]->at(col, row) - under_m;
  };
  double largest_m = 0.0;
  double steepest_m = 0.0;  // how much it changes from sample to sample
  for (int row = 0; row <= cells; ++row) {
    float before_m = raster::kNoData;
    for (int col = 0; col <= cells; ++col) {
      const float way_m = wayUp_m(col, row);
      if (!raster::isNoData(way_m)) {
        largest_m = std::max(largest_m, static_cast<double>(std::abs(way_m)));
        if (!raster::isNoData(before_m))
          steepest_m = std::max(steepest_m, static_cast<double>(std::abs(way_m - before_m)));
      }
      before_m = way_m;
    }
  }
  const double share = std::min(std::numbers::sqrt2 * spacing_m / sampler.seam()->width_m(), 1.0);
  return std::min(0.75 * share * share * largest_m + 0.75 * share * steepest_m, largest_m);
}

}  // namespace

GroundLayers::GroundLayers(tiling::Tiling tiling, std::vector<Layer> layers, int cells)
    : tiling_(tiling), layers_(std::move(layers)), cells_(cells) {
  for (std::size_t i = 0; i < layers_.size(); ++i)
    seams_.push_back(std::make_shared<raster::LateSeam>());
}

/// Null: it ends with a step, or nothing lies below it.
const raster::Seam* GroundLayers::seamOf(std::size_t layer) const {
  if (layer == 0) return nullptr;
  LayerTiles& tiles = *layers_[layer].tiles;
  const auto told = [&](const tiling::TileId& id) {
    return tiles.tellsPresence() ? std::optional(tiles.storedLevel(id) == id.level) : std::nullopt;
  };
  const auto nearest = [&](const tiling::TileId& id) -> raster::NearestTiles::Found {
    const int stored = tiles.storedLevel(id);
    return stored < 0 ? raster::NearestTiles::Found{}
                      : raster::NearestTiles::Found{.tile = tiles.get(id.ancestor(stored)), .level = stored};
  };
  return seams_[layer]->get(tiles.info(), layers_[layer].seam_m, told, nearest);
}

int GroundLayers::storedLevel(const tiling::TileId& id) const {
  int level = -1;
  for (const Layer& layer : layers_)
    level = std::max(level, layer.storedLevel(id));
  return level;
}

void GroundLayers::addNeeds(const tiling::TileId& id, std::vector<TileNeed>& needs) const {
  const std::size_t before = needs.size();
  std::optional<Touching> others;
  bool mayBeOwn = false;
  for (const Layer& layer : layers_) {
    if (!layer.tiles->tellsPresence()) {
      mayBeOwn = mayBeOwn || id.level <= layer.tiles->info().maxLevel;
      continue;
    }
    if (!others) others = touching(tiling_, id);
    const StoredLevels levels(id, *others, cells_, [&](const tiling::TileId& t) { return layer.storedLevel(t); });
    mayBeOwn = mayBeOwn || levels.own() == id.level;
    std::uint32_t asked = 0;
    levels.forEachLevel([&](int level) {
      if (level < 0 || ((asked >> level) & 1u) != 0) return;
      asked |= 1u << level;
      addNeed(*layer.tiles, id, level, needs);
    });
  }
  if (!mayBeOwn) needs.resize(before);
}

float GroundLayers::farHeight_m() const {
  std::call_once(far_->known, [&] {
    bool any = false;
    HeightRange range{.low_m = kWildestHeight_m, .high_m = -kWildestHeight_m};
    for (const Layer& layer : layers_) {
      for (int root = 0; root < tiling_.rootCount(); ++root) {
        const tiling::TileId id{.level = 0, .root = static_cast<std::uint8_t>(root)};
        const auto tile = layer.storedLevel(id) == 0 ? layer.tiles->get(id) : nullptr;
        if (!tile || !(tile->statistics.min_m <= tile->statistics.max_m)) continue;
        range.low_m = std::min(range.low_m, static_cast<double>(tile->statistics.min_m));
        range.high_m = std::max(range.high_m, static_cast<double>(tile->statistics.max_m));
        any = true;
      }
    }
    if (any && range.low_m > 0.0) far_->height_m = static_cast<float>(std::min(range.low_m, kWildestHeight_m));
    if (any && range.high_m < 0.0) far_->height_m = static_cast<float>(std::max(range.high_m, -kWildestHeight_m));
  });
  return far_->height_m;
}

ComposedGround GroundLayers::compose(const tiling::TileId& id, const GroundSamples* parent) const {
  ComposedGround ground{.heights = GroundSamples(cells_ + 3, cells_ + 3, farHeight_m())};
  const Touching others = touching(tiling_, id);
  const StoredLevels levels(id, others, cells_, [&](const tiling::TileId& t) { return storedLevel(t); });
  ground.level = levels.own();
  Samplers samplers;
  if (levels.own() == id.level) {
    for (std::size_t i = 0; i < layers_.size(); ++i)
      samplers.push_back(std::make_unique<LayerSampler>(layers_[i], tiling_, id, others, cells_, seamOf(i)));
  }
  GroundSamples made;
  for (int row = -1; levels.own() >= 0 && row <= cells_ + 1; ++row) {
    for (int col = -1; col <= cells_ + 1; ++col) {
      const bool isOwn = id.level == 0 || levels.at(col, row) == id.level;
      float height_m = isOwn ? composedAt(samplers, col, row) : raster::kNoData;
      if (isOwn && raster::isNoData(height_m)) height_m = besideGap(samplers, cells_, id.level, col, row);
      if (raster::isNoData(height_m)) {
        if (id.level == 0) continue;
        if (parent == nullptr) {
          made = compose(id.parent(), nullptr).heights;
          parent = &made;
        }
        height_m = betweenParents(*parent, id, cells_, col, row);
      }
      ground.heights.at(col + 1, row + 1) = height_m;
    }
  }
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const Quarter q = quarterOf(quadrant, cells_);
    const auto first = static_cast<double>(ground.heights.at(q.firstCol + 1, q.firstRow + 1));
    HeightRange& range = ground.childRange[q.quadrant];
    range = {.low_m = first, .high_m = first};
    forEachSample(q, [&](int col, int row) { unite(range, static_cast<double>(ground.heights.at(col + 1, row + 1))); });
    if (quadrant == 0) ground.range = range;
    unite(ground.range, range);
  }
  for (const auto& sampler : samplers) {
    if (sampler->ownTile() != nullptr) addFacts(ground, *sampler->ownTile());
  }
  if (!samplers.empty()) {
    const double radius_m = layers_.front().tiles->info().body.ellipsoid.semiMajorAxis_m();
    const double spacing_m = tiling_.metrics(id.level).largestEdge.radians() / cells_ * radius_m;
    const bool isDeepest = std::none_of(samplers.begin(), samplers.end(), [](const auto& sampler) {
      return sampler->ownTile() != nullptr && sampler->ownTile()->childMask != 0;
    });
    for (std::size_t i = 1; i < samplers.size() && !isDeepest; ++i) {
      if (samplers[i]->seam() != nullptr) ground.error_m += seamError_m(samplers, i, cells_, spacing_m);
    }
    addGaps(ground, samplers, cells_, spacing_m);
  }
  return ground;
}

}  // namespace tellurion::scene
