#include "pyramid/imagery_cleaning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "geo/shared_rect.h"
#include "pyramid/input_set.h"
#include "pyramid/memory_budget.h"
#include "raster/block_cache.h"
#include "raster/cloud_mask.h"
#include "raster/colour.h"
#include "raster/land_mask.h"

namespace tellurion::pyramid {
namespace {

using raster::Raster;
using raster::Rgba8;
using raster::WeightMap;

constexpr double kMapBytes = 256.0 * (1 << 20);
constexpr int kMostCloudNodes = 2048;
/// What a node of a map takes while the map is made, itself included: distances, and what they are told from.
constexpr std::uint64_t kBytesOfNode = 6;
/// The same of clouds: how bright each node is, twice, and marks.
constexpr std::uint64_t kBytesOfCloudNode = 24;
constexpr std::uint64_t kBytesOfMatch = std::uint64_t{48} << 20u;  // the places that two pictures are compared at
/// A ramp is made of so many nodes at least, as far as the map's size allows.
constexpr double kNodesPerRamp = 16.0;
/// How much finer than the clear map, the first input, clouds are looked for: what is smaller is more often a field
/// than a cloud.
constexpr double kFinerThanClear = 32.0;
/// Around clouds, of their own map: --feather would leave little between scattered ones.
constexpr double kCloudRim_nodes = 3.0;

/// Nodes a side.
int mostNodes(const BuildPlan& plan) {
  const double maps = 3.0 * static_cast<double>(std::max<std::size_t>(plan.inputs.size(), 1));
  return std::min(raster::kMostMapNodes, static_cast<int>(std::sqrt(kMapBytes / maps)));
}

/// Of a map with ramps of --feather: what is built of an input, and as much around it as reaches into that.
raster::LonLatGrid rampGrid(const BuildPlan& plan, int input) {
  const PlannedInput& planned = plan.inputs[static_cast<std::size_t>(input)];
  const double radius_m = plan.meta.body.ellipsoid.meanRadius_m();
  const auto ramp = geo::Angle::radians(plan.cleaning.feather_m / radius_m);
  const geo::Angle spacing = std::max(planned.spacing, ramp / kNodesPerRamp);
  const auto area = geo::sharedRect(planned.extent, planned.bounds.grown(ramp * 1.01 + spacing));
  return raster::gridOfSpacing(plan.region && area ? *area : planned.extent, spacing, mostNodes(plan));
}

raster::LonLatGrid cloudGrid(const BuildPlan& plan, int input) {
  const PlannedInput& planned = plan.inputs[static_cast<std::size_t>(input)];
  const geo::Angle spacing = std::max(planned.spacing, plan.inputs.front().spacing / kFinerThanClear);
  return raster::gridOfSpacing(planned.bounds, spacing, std::min(kMostCloudNodes, mostNodes(plan)));
}

/// The first input of a database lies over nothing.
int lowestToMap(const BuildPlan& plan) {
  return plan.base ? 0 : 1;
}

/// What the maps take at most while they are made.
std::uint64_t bytesToPrepare(const BuildPlan& plan) {
  const CleaningOptions& options = plan.cleaning;
  std::uint64_t kept = 0;
  std::uint64_t passing = options.matchColours || options.clouds ? kBytesOfMatch : 0;
  const auto count = [&](const raster::LonLatGrid& grid, std::uint64_t bytesOfNode) {
    const std::uint64_t nodes = static_cast<std::uint64_t>(grid.width) * static_cast<std::uint64_t>(grid.height);
    kept += nodes;
    passing = std::max(passing, nodes * bytesOfNode);
  };
  for (int input = lowestToMap(plan); input < static_cast<int>(plan.inputs.size()); ++input) {
    if (!options.cutAt.empty()) count(rampGrid(plan, input), kBytesOfNode);
    if (options.feather_m > 0.0) count(rampGrid(plan, input), kBytesOfNode);
    if (options.clouds) count(cloudGrid(plan, input), kBytesOfCloudNode);
  }
  return kept + passing;
}

std::uint8_t byteOf(double share) {
  return static_cast<std::uint8_t>(std::lround(255.0 * share));
}

}  // namespace

/// Reads the inputs and fills the entries, topmost last. One thread only.
class ImageryCleaning::Preparation {
 public:
  Preparation(const BuildPlan& plan, const MemoryBudget& budget, ImageryCleaning& cleaning, std::stop_token stop)
      : plan_(plan),
        options_(plan.cleaning),
        cleaning_(cleaning),
        stop_(std::move(stop)),
        inputs_(plan, budget.openFiles, budget.bytesPerFile),
        blockCache_(budget.blockCacheBytes),
        count_(static_cast<int>(plan.inputs.size())) {}

  io::Result<void> run() {
    for (int input = lowestToMap(plan_); input < count_; ++input) {
      if (!options_.cutAt.empty()) {
        if (auto ok = cut(input); !ok) return ok;
      }
      if (options_.feather_m > 0.0) {
        if (auto ok = feather(input); !ok) return ok;
      }
      if (options_.clouds) {
        if (auto ok = removeClouds(input); !ok) return ok;
      }
    }
    for (int input = count_ - 2; options_.matchColours && input >= 0; --input) {
      if (auto ok = match(input); !ok) return ok;
    }
    return {};
  }

 private:
  const PlannedInput& planned(int input) const { return plan_.inputs[static_cast<std::size_t>(input)]; }
  Entry& entry(int input) { return cleaning_.entries_[static_cast<std::size_t>(input)]; }

  io::Result<void> goOn() const {
    if (!stop_.stop_requested()) return {};
    return io::fail(io::Failure::Code::cancelled, "stopped");
  }

  /// Where the map's size does not allow the ramp that was asked for.
  void warnOfNarrowRamp(int input, const raster::LonLatGrid& grid) {
    double step_m = grid.rowStep_m(plan_.meta.body);
    for (int row = 0; row < grid.height; ++row)
      step_m = std::max(step_m, grid.columnStep_m(plan_.meta.body, row));
    if (options_.feather_m == 0.0 || step_m <= options_.feather_m) return;
    cleaning_.warnings_.push_back(
        fmt::format("{}: --feather {:g} is narrower than its map can tell: it fades over {:.0f} m", planned(input).path,
                    options_.feather_m, step_m));
  }

  /// 1 in the polygons, fading to 0 over the feather's width outside.
  io::Result<void> cut(int input) {
    if (auto ok = goOn(); !ok) return ok;
    const raster::LonLatGrid grid = rampGrid(plan_, input);
    auto land = raster::insidePolygons(options_.cutAt, grid, stop_);
    if (!land) return tl::unexpected(land.error());
    Raster<std::uint8_t> sea(grid.width, grid.height);
    std::ranges::transform(land->samples, sea.samples.begin(), [](std::uint8_t l) { return l == 0 ? 1 : 0; });
    const auto distances = raster::distancesToUnmarked(grid, sea, plan_.meta.body, options_.feather_m + 1.0, false);
    std::ranges::transform(distances.samples, sea.samples.begin(), [&](float d) {
      return byteOf(1.0 - raster::rampOf(static_cast<double>(d), options_.feather_m));
    });
    if (std::ranges::all_of(sea.samples, [](std::uint8_t share) { return share == 0; })) {
      cleaning_.warnings_.push_back(
          fmt::format("{}: no polygon of --cut meets it, so nothing of it is shown", planned(input).path));
    }
    warnOfNarrowRamp(input, grid);
    entry(input).land = WeightMap{grid, std::move(sea)};
    return {};
  }

  /// 0 at the border of its data, rising to 1 over the feather's width inside.
  io::Result<void> feather(int input) {
    const raster::LonLatGrid grid = rampGrid(plan_, input);
    const geo::Angle footprint = (grid.bounds.north - grid.bounds.south) / grid.height;
    Raster<std::uint8_t> covered(grid.width, grid.height);
    std::vector<Rgba8> colours;
    for (int row = 0; row < grid.height; ++row) {
      if (auto ok = goOn(); !ok) return ok;
      const auto places = grid.places(row);
      colours.assign(places.size(), {});
      if (auto ok = inputs_.coloursAt(input, places, footprint, colours); !ok) return ok;
      for (int col = 0; col < grid.width; ++col)
        covered.at(col, row) = colours[static_cast<std::size_t>(col)].a > 0 ? 1 : 0;
    }
    const auto distances = raster::distancesToUnmarked(grid, covered, plan_.meta.body, options_.feather_m, true);
    std::ranges::transform(distances.samples, covered.samples.begin(),
                           [&](float d) { return byteOf(raster::rampOf(static_cast<double>(d), options_.feather_m)); });
    warnOfNarrowRamp(input, grid);
    entry(input).rim = WeightMap{grid, std::move(covered)};
    return {};
  }

  io::Result<void> removeClouds(int input) {
    if (auto ok = goOn(); !ok) return ok;
    const raster::LonLatGrid grid = cloudGrid(plan_, input);
    const auto clear = [&](std::span<const geo::Direction> places, geo::Angle footprint, std::span<Rgba8> out) {
      io::Result<void> ok = goOn();
      for (int below = 0; ok && below < input; ++below)
        ok = inputs_.coloursAt(below, places, footprint, out);
      return ok;
    };
    auto clouds = raster::findClouds(samplerOf(input), clear, grid);
    if (!clouds) return tl::unexpected(clouds.error());
    std::ranges::transform(clouds->samples, clouds->samples.begin(), [](std::uint8_t c) { return c == 0 ? 1 : 0; });
    const double rim_m = kCloudRim_nodes * grid.rowStep_m(plan_.meta.body);
    const auto distances = raster::distancesToUnmarked(grid, *clouds, plan_.meta.body, rim_m, false);
    std::ranges::transform(distances.samples, clouds->samples.begin(),
                           [&](float d) { return byteOf(raster::rampOf(static_cast<double>(d), rim_m)); });
    entry(input).clear = WeightMap{grid, std::move(*clouds)};
    return {};
  }

  /// To what lies above it, which is matched already.
  io::Result<void> match(int input) {
    if (auto ok = goOn(); !ok) return ok;
    std::vector<geo::GeoRect> shared;
    geo::Angle spacing = planned(input).spacing;
    for (int other = input + 1; other < count_; ++other) {
      const auto both = geo::sharedRect(planned(input).bounds, planned(other).bounds);
      if (!both || !(both->south < both->north && both->width > geo::Angle())) continue;
      shared.push_back(*both);
      spacing = std::max(spacing, planned(other).spacing);
    }
    if (shared.empty()) return {};
    const auto laid = [&](std::span<const geo::Direction> places, geo::Angle footprint, std::span<Rgba8> out) {
      return cleanedAbove(input, places, footprint, out);
    };
    auto found = raster::matchColours(samplerOf(input), laid, shared, spacing);
    if (!found) return tl::unexpected(found.error());
    entry(input).match = std::move(*found);
    return {};
  }

  /// The inputs above one, where they are neither cut off nor cloudy.
  io::Result<void> cleanedAbove(int input, std::span<const geo::Direction> places, geo::Angle footprint,
                                std::span<Rgba8> out) {
    if (auto ok = goOn(); !ok) return ok;
    std::vector<Rgba8> own;
    for (int other = input + 1; other < count_; ++other) {
      own.assign(places.size(), {});
      if (auto ok = inputs_.coloursAt(other, places, footprint, own); !ok) return ok;
      const Entry& e = entry(other);
      for (std::size_t i = 0; i < places.size(); ++i) {
        if (own[i].a == 0) continue;
        if (e.land && e.land->at(places[i]) < 1.0) continue;
        if (e.clear && e.clear->at(places[i]) < 1.0) continue;
        out[i] = raster::over(e.match ? e.match->apply(places[i], own[i]) : own[i], out[i]);
      }
    }
    return {};
  }

  raster::ColourSampler samplerOf(int input) {
    return [this, input](std::span<const geo::Direction> places, geo::Angle footprint, std::span<Rgba8> out) {
      if (auto ok = goOn(); !ok) return ok;
      return inputs_.coloursAt(input, places, footprint, out);
    };
  }

  const BuildPlan& plan_;
  const CleaningOptions& options_;
  ImageryCleaning& cleaning_;
  std::stop_token stop_;
  InputSet inputs_;
  raster::BlockCacheLimit blockCache_;
  int count_;
};

io::Result<std::shared_ptr<const ImageryCleaning>> ImageryCleaning::prepare(const BuildPlan& plan,
                                                                            std::uint64_t memoryBytes,
                                                                            std::stop_token stop) {
  if (!plan.cleaning.asksForAnything()) return nullptr;
  const std::uint64_t needed = bytesToPrepare(plan);
  if (memoryBytes < kLeastMemory + needed) {
    constexpr std::uint64_t kMiB = std::uint64_t{1} << 20u;
    return io::fail(io::Failure::Code::invalidArgument,
                    fmt::format("cleaning these inputs takes at least {} MiB of memory: give it with --memory",
                                (kLeastMemory + needed + kMiB - 1) / kMiB));
  }
  const MemoryBudget budget = memoryBudget(memoryBytes - needed, 1, plan.inputs.size());
  auto cleaning = std::make_shared<ImageryCleaning>();
  cleaning->entries_.resize(plan.inputs.size());
  if (auto ok = Preparation(plan, budget, *cleaning, std::move(stop)).run(); !ok) return tl::unexpected(ok.error());
  return cleaning;
}

std::uint64_t ImageryCleaning::bytes() const {
  std::uint64_t bytes = 0;
  for (const Entry& entry : entries_) {
    for (const std::optional<WeightMap>* map : {&entry.land, &entry.rim, &entry.clear})
      bytes += *map ? (*map)->weights.samples.size() : 0;
  }
  return bytes;
}

void ImageryCleaning::lay(int input, std::span<const geo::Direction> places, std::span<Rgba8> own,
                          std::span<Rgba8> out) const {
  const Entry& entry = entries_[static_cast<std::size_t>(input)];
  for (std::size_t i = 0; i < places.size(); ++i) {
    Rgba8 colour = own[i];
    if (colour.a == 0) continue;
    if (entry.match) colour = entry.match->apply(places[i], colour);
    double share = entry.land ? entry.land->at(places[i]) : 1.0;
    // It gives way only as far as there is something to give way to.
    const double below = static_cast<double>(out[i].a) / 255.0;
    if (entry.rim) share *= 1.0 - below * (1.0 - entry.rim->at(places[i]));
    if (entry.clear) share *= 1.0 - below * (1.0 - entry.clear->at(places[i]));
    colour.a = static_cast<std::uint8_t>(std::lround(share * colour.a));
    out[i] = raster::over(colour, out[i]);
  }
}

}  // namespace tellurion::pyramid
