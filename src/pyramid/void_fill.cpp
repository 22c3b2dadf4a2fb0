#include "pyramid/void_fill.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pyramid/sample_views.h"

namespace tellurion::pyramid {
namespace {

using raster::isNoData;
using raster::kGutter;
using raster::kNoData;

constexpr int kBlockCells = 8;
constexpr std::int8_t kNoDepth = -1;

/// Places no farther from a centre than a radius; distances are chords of the unit sphere.
struct Ball {
  geo::Vec3 centre{0.0, 0.0, 0.0};
  double radius = 0.0;

  /// Surely none of the one is as near as `reach` to one of the other.
  bool isBeyond(double reach, const Ball& other) const {
    const geo::Vec3 way = other.centre - centre;
    const double sum = radius + other.radius + reach;
    return geo::dot(way, way) > sum * sum * (1.0 + 1e-12);
  }
};

Ball ballOf(const tiling::Cap& cap) {
  return {cap.centre.n, cap.radius.radians()};  // an arc is longer than its chord
}

Ball ballAround(std::span<const geo::Direction> places) {
  geo::Vec3 sum(0.0, 0.0, 0.0);
  for (const geo::Direction& place : places)
    sum += place.n;
  Ball ball{sum / static_cast<double>(places.size()), 0.0};
  for (const geo::Direction& place : places)
    ball.radius = std::max(ball.radius, geo::length(place.n - ball.centre));
  return ball;
}

/// Residuals at some distances, put together for one place. Distances are chords, in parts of the reach.
class WeightedMean {
 public:
  void add(double distance, double residual) {
    const double fade = 1.0 - distance;
    const double weight = fade * fade / (distance * distance + kSame2);
    sum_ += weight * residual;
    weights_ += weight;
    nearest_ = std::min(nearest_, distance);
  }
  double value() const {
    if (weights_ == 0.0) return 0.0;
    const double share = std::min((1.0 - nearest_) / (1.0 - kWhole), 1.0);
    return sum_ / weights_ * share * share * (3.0 - 2.0 * share);
  }

 private:
  static constexpr double kSame2 = 1e-12;  ///< at a sample its residual is all
  static constexpr double kWhole = 0.5;    ///< up to here, two samples, nothing fades
  double sum_ = 0.0;
  double weights_ = 0.0;
  double nearest_ = 1.0;
};

}  // namespace

/// What the inputs and the base hold at some places, nothing moved or filled.
struct VoidFill::Layers {
  /// The topmost of all inputs that are no deeper.
  struct Stratum {
    int depth;
    std::vector<float> heights_m;
    std::vector<std::int8_t> depths;
  };
  std::vector<Stratum> strata;  ///< of each depth that an input has, ascending
  std::vector<float> base_m;
  std::vector<std::int8_t> baseDepths;

  struct Data {
    float height_m = kNoData;
    int depth = kNoDepth;
  };
  Data ofInputs(std::size_t i, int level) const {
    const auto deeper = std::ranges::upper_bound(strata, level, {}, &Stratum::depth);
    if (deeper == strata.begin()) return {};
    const Stratum& stratum = *std::prev(deeper);
    return {stratum.heights_m[i], stratum.depths[i]};
  }
  Data ofBase(std::size_t i) const { return {base_m[i], baseDepths[i]}; }
  /// The topmost of the inputs down to the level; the base where these have none.
  Data at(std::size_t i, int level) const {
    const Data inputs = ofInputs(i, level);
    return inputs.depth == kNoDepth ? ofBase(i) : inputs;
  }
  Data top(std::size_t i) const { return at(i, tiling::kMaxLevel); }
};

/// The samples of a tile of level L that residuals come from. Of a sample on a border one tile is the owner.
struct VoidFill::Lattice {
  /// Some that lie together.
  struct Block {
    Ball ball;
    std::vector<std::size_t> samples;
  };
  Ball ball;
  raster::OpenPlaces samples;
  Layers layers;
  std::vector<double> residuals_m;  ///< NaN where there is none
  std::vector<bool> known;          ///< that the residual has been made
  std::vector<Block> blocks;
};

/// A place, and a sample within reach of it.
struct VoidFill::Pair {
  std::size_t place;
  std::size_t lattice;
  std::size_t sample;
  double distance;
};

VoidFill::VoidFill(const BuildPlan& plan, const BaseLayer* base, InputSet& inputs, std::size_t mostLattices)
    : plan_(plan), base_(base), inputs_(inputs), mostLattices_(mostLattices) {}
VoidFill::~VoidFill() = default;

io::Result<VoidFill::Layers> VoidFill::layersAt(const tiling::TileId& id, std::span<const int> inputs,
                                                const raster::OpenPlaces& samples) {
  const std::size_t count = samples.places.size();
  Layers layers{.strata = {},
                .base_m = std::vector<float>(count, kNoData),
                .baseDepths = std::vector<std::int8_t>(count, kNoDepth)};
  if (base_ != nullptr) {
    const auto below = base_->heights(id);
    if (!below) return tl::unexpected(below.error());
    for (std::size_t i = 0; i < count; ++i) {
      layers.base_m[i] = below->heights.samples[samples.indices[i]];
      layers.baseDepths[i] = below->depths[samples.indices[i]];
    }
  }
  std::vector<float> heights(count);
  for (const int input : inputs) {
    const int depth = plan_.inputs[static_cast<std::size_t>(input)].depth;
    if (std::ranges::find(layers.strata, depth, &Layers::Stratum::depth) == layers.strata.end()) {
      layers.strata.push_back({depth, std::vector<float>(count, kNoData), std::vector<std::int8_t>(count, kNoDepth)});
    }
  }
  std::ranges::sort(layers.strata, {}, &Layers::Stratum::depth);
  for (const int input : inputs) {
    std::ranges::fill(heights, kNoData);
    if (auto ok = inputs_.heights(std::span(&input, 1), id, samples.indices, heights); !ok)
      return tl::unexpected(ok.error());
    const int depth = plan_.inputs[static_cast<std::size_t>(input)].depth;
    for (Layers::Stratum& stratum : layers.strata) {
      if (stratum.depth < depth) continue;
      for (std::size_t i = 0; i < count; ++i) {
        if (isNoData(heights[i])) continue;
        stratum.heights_m[i] = heights[i];
        stratum.depths[i] = static_cast<std::int8_t>(depth);
      }
    }
  }
  return layers;
}

io::Result<VoidFill::Heights> VoidFill::heights(const tiling::TileId& id, std::span<const int> inputs,
                                                const raster::OpenPlaces& samples) {
  const auto layers = layersAt(id, inputs, samples);
  if (!layers) return tl::unexpected(layers.error());
  Heights result;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < samples.places.size(); ++i) {
    const Layers::Data top = layers->top(i);
    result.heights_m.push_back(top.height_m);
    result.depths.push_back(static_cast<std::int8_t>(top.depth));
    // Data of this level or deeper stands as it is; around coarser data something finer may be.
    if (top.depth != kNoDepth && top.depth < id.level) open.push_back(i);
  }
  const auto filled = surface(*layers, samples.places, open, id.level);
  if (!filled) return tl::unexpected(filled.error());
  for (std::size_t i = 0; i < open.size(); ++i)
    result.heights_m[open[i]] = static_cast<float>((*filled)[i]);
  return result;
}

io::Result<std::vector<double>> VoidFill::surface(const Layers& layers, std::span<const geo::Direction> places,
                                                  std::span<const std::size_t> which, int to) {
  const FillPlan& fill = plan_.fill;
  std::vector<double> heights;
  heights.reserve(which.size());
  for (const std::size_t i : which)
    heights.push_back(static_cast<double>(layers.at(i, std::min(fill.fromLevel, to)).height_m));
  std::vector<std::size_t> moved;
  std::vector<geo::Direction> placesMoved;
  for (int level = fill.fromLevel + 1; level <= to; ++level) {
    moved.clear();
    placesMoved.clear();
    for (std::size_t k = 0; k < which.size(); ++k) {
      const Layers::Data data = layers.at(which[k], level);
      if (data.depth == level) {
        heights[k] = static_cast<double>(data.height_m);
      } else if (!std::isnan(heights[k])) {
        moved.push_back(k);
        placesMoved.push_back(places[which[k]]);
      }
    }
    if (fill.reach(level) == 0.0 || moved.empty()) continue;
    const auto by = movedBy(level, placesMoved);
    if (!by) return tl::unexpected(by.error());
    for (std::size_t k = 0; k < moved.size(); ++k)
      heights[moved[k]] += (*by)[k];
  }
  return heights;
}

io::Result<std::vector<double>> VoidFill::movedBy(int level, std::span<const geo::Direction> places) {
  std::vector<double> by(places.size(), 0.0);
  const auto lattices = latticesNear(level, places);
  if (!lattices) return tl::unexpected(lattices.error());
  const double reach = plan_.fill.reach(level);
  std::vector<Pair> pairs;  // in an order that depends on the places' surroundings alone
  for (std::size_t p = 0; p < places.size(); ++p) {
    const Ball here{places[p].n, 0.0};
    for (std::size_t l = 0; l < lattices->size(); ++l) {
      const Lattice& lattice = *(*lattices)[l];
      if (here.isBeyond(reach, lattice.ball)) continue;
      for (const Lattice::Block& block : lattice.blocks) {
        if (here.isBeyond(reach, block.ball)) continue;
        for (const std::size_t s : block.samples) {
          const double distance = geo::length(places[p].n - lattice.samples.places[s].n) / reach;
          if (distance < 1.0) pairs.push_back({p, l, s, distance});
        }
      }
    }
  }
  if (auto ok = makeResiduals(pairs, *lattices, level); !ok) return tl::unexpected(ok.error());
  for (std::size_t first = 0, end = 0; first < pairs.size(); first = end) {
    WeightedMean mean;
    for (end = first; end < pairs.size() && pairs[end].place == pairs[first].place; ++end) {
      const double residual = (*lattices)[pairs[end].lattice]->residuals_m[pairs[end].sample];
      if (!std::isnan(residual)) mean.add(pairs[end].distance, residual);
    }
    by[pairs[first].place] = mean.value();
  }
  return by;
}

/// Those residuals that are asked for and not known yet.
io::Result<void> VoidFill::makeResiduals(const std::vector<Pair>& pairs, const Lattices& lattices, int level) {
  std::vector<std::vector<std::size_t>> wanted(lattices.size());
  for (const Pair& pair : pairs) {
    Lattice& lattice = *lattices[pair.lattice];
    if (lattice.known[pair.sample]) continue;
    lattice.known[pair.sample] = true;
    wanted[pair.lattice].push_back(pair.sample);
  }
  for (std::size_t l = 0; l < lattices.size(); ++l) {
    if (wanted[l].empty()) continue;
    Lattice& lattice = *lattices[l];
    const auto below = surface(lattice.layers, lattice.samples.places, wanted[l], level - 1);
    if (!below) return tl::unexpected(below.error());
    for (std::size_t k = 0; k < wanted[l].size(); ++k) {
      const std::size_t s = wanted[l][k];
      lattice.residuals_m[s] = static_cast<double>(lattice.layers.top(s).height_m) - (*below)[k];
    }
  }
  return {};
}

/// In the order of their ids; those without a sample that counts are left out.
io::Result<VoidFill::Lattices> VoidFill::latticesNear(int level, std::span<const geo::Direction> places) {
  const tiling::Tiling tiling = plan_.tiling();
  const Ball around = ballAround(places);
  const double reach = plan_.fill.reach(level);
  std::vector<tiling::TileId> tiles;
  for (int root = 0; root < tiling.rootCount(); ++root)
    tiles.push_back({.level = 0, .root = static_cast<std::uint8_t>(root), .x = 0, .y = 0});
  const auto isApart = [&](const tiling::TileId& id) { return around.isBeyond(reach, ballOf(tiling.cap(id))); };
  std::erase_if(tiles, isApart);
  for (int below = 1; below <= level; ++below) {
    std::vector<tiling::TileId> children;
    for (const tiling::TileId& id : tiles) {
      for (int quadrant = 0; quadrant < 4; ++quadrant)
        children.push_back(id.child(quadrant));
    }
    std::erase_if(children, isApart);
    tiles = std::move(children);
  }
  std::ranges::sort(tiles);
  Lattices lattices;
  for (const tiling::TileId& id : tiles) {
    auto found = lattice(id);
    if (!found) return tl::unexpected(found.error());
    if (!(*found)->blocks.empty()) lattices.push_back(std::move(*found));
  }
  return lattices;
}

io::Result<std::shared_ptr<VoidFill::Lattice>> VoidFill::lattice(const tiling::TileId& id) {
  if (const auto known = kept_.find(id); known != kept_.end()) {
    known->second.lastUse = ++uses_;
    return known->second.lattice;
  }
  auto made = makeLattice(id);
  if (!made) return made;
  if (kept_.size() >= mostLattices_) {
    kept_.erase(std::ranges::min_element(kept_, {}, [](const auto& entry) { return entry.second.lastUse; }));
  }
  kept_[id] = {*made, ++uses_};
  return made;
}

io::Result<std::shared_ptr<VoidFill::Lattice>> VoidFill::makeLattice(const tiling::TileId& id) {
  const tiling::Tiling tiling = plan_.tiling();
  const int cells = plan_.meta.tileCells;
  auto lattice = std::make_shared<Lattice>();
  lattice->ball = ballOf(tiling.cap(id));
  std::vector<int> inputs;
  int deepest = kNoDepth;
  for (int i = 0; i < static_cast<int>(plan_.inputs.size()); ++i) {
    const PlannedInput& input = plan_.inputs[static_cast<std::size_t>(i)];
    if (!input.bounds.intersects(tiling.bounds(id))) continue;
    const auto may = inputs_.mayTouch(i, id, {});
    if (!may) return tl::unexpected(may.error());
    if (!*may) continue;
    inputs.push_back(i);
    deepest = std::max(deepest, input.depth);
  }
  const bool baseCounts = base_ != nullptr && id.level > plan_.fill.baseFromLevel;
  if (deepest < id.level && !baseCounts) return lattice;
  const int side = sideOf(raster::Kind::elevation, cells);
  std::vector<bool> isGutter(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), true);
  for (int row = 0; row <= cells; ++row) {
    for (int column = 0; column <= cells; ++column)
      isGutter[static_cast<std::size_t>((row + kGutter) * side + column + kGutter)] = false;
  }
  lattice->samples = openPlaces(tiling, id, raster::Kind::elevation, cells, isGutter);
  auto layers = layersAt(id, inputs, lattice->samples);
  if (!layers) return tl::unexpected(layers.error());
  lattice->layers = std::move(*layers);
  const std::size_t count = lattice->samples.places.size();
  lattice->residuals_m.assign(count, kNoData);
  lattice->known.assign(count, false);

  const auto isOwner = [&](int column, int row) {
    if (column != 0 && column != cells && row != 0 && row != cells) return true;
    return std::ranges::min(viewsOf(tiling, {id, column, row}, cells), {}, &SampleView::tile).tile == id;
  };
  const auto counts = [&](std::size_t i, int column, int row) {
    const Layers::Data inputsTop = lattice->layers.ofInputs(i, tiling::kMaxLevel);
    if (inputsTop.depth == kNoDepth && !baseCounts) return false;
    return lattice->layers.top(i).depth >= id.level && isOwner(column, row);
  };
  for (int row0 = 0; row0 <= cells; row0 += kBlockCells) {
    for (int column0 = 0; column0 <= cells; column0 += kBlockCells) {
      Lattice::Block block;
      std::vector<geo::Direction> places;
      for (int row = row0; row < row0 + kBlockCells && row <= cells; ++row) {
        for (int column = column0; column < column0 + kBlockCells && column <= cells; ++column) {
          const auto i = static_cast<std::size_t>(row * (cells + 1) + column);
          if (!counts(i, column, row)) continue;
          block.samples.push_back(i);
          places.push_back(lattice->samples.places[i]);
        }
      }
      if (block.samples.empty()) continue;
      block.ball = ballAround(places);
      lattice->blocks.push_back(std::move(block));
    }
  }
  return lattice;
}

}  // namespace tellurion::pyramid
