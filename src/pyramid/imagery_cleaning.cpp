#include "pyramid/imagery_cleaning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pyramid/input_set.h"
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
constexpr std::size_t kMostOpen = 16;
constexpr std::size_t kCacheBytes = std::size_t{16} << 20u;
/// A ramp is made of so many nodes at least, as far as the map's size allows.
constexpr double kNodesPerRamp = 16.0;
/// How much finer than the clear map, the first input, clouds are looked for: what is smaller is more often a field
/// than a cloud.
constexpr double kFinerThanClear = 32.0;
/// Around clouds, of their own map: --feather would leave little between scattered ones.
constexpr double kCloudRim_nodes = 3.0;

std::uint8_t byteOf(double share) {
  return static_cast<std::uint8_t>(std::lround(255.0 * share));
}

/// What both hold; nothing where they do not meet. Where they meet twice, the wider part.
std::optional<geo::GeoRect> meeting(const geo::GeoRect& a, const geo::GeoRect& b) {
  const double south = std::max(a.south.degrees(), b.south.degrees());
  const double north = std::min(a.north.degrees(), b.north.degrees());
  if (!(south < north)) return std::nullopt;
  std::optional<std::pair<double, double>> widest;
  const double aWest = a.west.degrees();
  for (const double turn : {-360.0, 0.0, 360.0}) {
    const double west = std::max(aWest, b.west.degrees() + turn);
    const double east = std::min(aWest + a.width.degrees(), b.west.degrees() + turn + b.width.degrees());
    if (west < east && (!widest || east - west > widest->second - widest->first)) widest = {west, east};
  }
  if (!widest) return std::nullopt;
  return geo::GeoRect{.south = geo::Angle::degrees(south),
                      .north = geo::Angle::degrees(north),
                      .west = geo::wrappedLongitude(geo::Angle::degrees(widest->first)),
                      .width = geo::Angle::degrees(widest->second - widest->first)};
}

}  // namespace

/// Reads the inputs and fills the entries, topmost last. One thread only.
class ImageryCleaning::Preparation {
 public:
  Preparation(const BuildPlan& plan, ImageryCleaning& cleaning, std::stop_token stop)
      : plan_(plan),
        options_(plan.cleaning),
        cleaning_(cleaning),
        stop_(std::move(stop)),
        inputs_(plan, kMostOpen, kCacheBytes),
        count_(static_cast<int>(plan.inputs.size())) {
    const double maps = 3.0 * std::max(count_, 1);
    mostNodes_ = std::min(raster::kMostMapNodes, static_cast<int>(std::sqrt(kMapBytes / maps)));
  }

  io::Result<void> run() {
    const int lowest = plan_.base ? 0 : 1;  // the first lies over nothing
    for (int input = lowest; input < count_; ++input) {
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

  raster::LonLatGrid gridFor(int input, double ramp_m, int mostNodes) const {
    const double wanted = ramp_m / kNodesPerRamp / plan_.meta.body.ellipsoid.meanRadius_m();
    const auto spacing = geo::Angle::radians(std::max(planned(input).spacing.radians(), wanted));
    return raster::gridOfSpacing(planned(input).bounds, spacing, mostNodes);
  }

  /// 1 in the polygons, fading to 0 over the feather's width outside.
  io::Result<void> cut(int input) {
    if (auto ok = goOn(); !ok) return ok;
    const raster::LonLatGrid grid = gridFor(input, options_.feather_m, mostNodes_);
    auto land = raster::insidePolygons(options_.cutAt, grid);
    if (!land) return tl::unexpected(land.error());
    Raster<std::uint8_t> sea(grid.width, grid.height);
    std::ranges::transform(land->samples, sea.samples.begin(), [](std::uint8_t l) { return l == 0 ? 1 : 0; });
    const auto distances = raster::distancesToUnmarked(grid, sea, plan_.meta.body, options_.feather_m + 1.0, false);
    std::ranges::transform(distances.samples, sea.samples.begin(), [&](float d) {
      return byteOf(1.0 - raster::rampOf(static_cast<double>(d), options_.feather_m));
    });
    entry(input).land = WeightMap{grid, std::move(sea)};
    return {};
  }

  /// 0 at the border of its data, rising to 1 over the feather's width inside.
  io::Result<void> feather(int input) {
    const raster::LonLatGrid grid = gridFor(input, options_.feather_m, mostNodes_);
    const geo::Angle footprint = (grid.bounds.north - grid.bounds.south) / grid.height;
    Raster<std::uint8_t> covered(grid.width, grid.height);
    std::vector<Rgba8> colours;
    for (int row = 0; row < grid.height; ++row) {
      if (auto ok = goOn(); !ok) return ok;
      const auto places = grid.places(row);
      colours.assign(places.size(), {});
      if (auto ok = inputs_.coloursAt(input, places, footprint, colours); !ok) return ok;
      for (int col = 0; col < grid.width; ++col)
        covered.at(col, row) = colours[static_cast<std::size_t>(col)].a == 255 ? 1 : 0;
    }
    const auto distances = raster::distancesToUnmarked(grid, covered, plan_.meta.body, options_.feather_m, true);
    std::ranges::transform(distances.samples, covered.samples.begin(),
                           [&](float d) { return byteOf(raster::rampOf(static_cast<double>(d), options_.feather_m)); });
    entry(input).rim = WeightMap{grid, std::move(covered)};
    return {};
  }

  io::Result<void> removeClouds(int input) {
    if (auto ok = goOn(); !ok) return ok;
    const geo::Angle spacing = std::max(planned(input).spacing, planned(0).spacing / kFinerThanClear);
    const raster::LonLatGrid grid =
        raster::gridOfSpacing(planned(input).bounds, spacing, std::min(kMostCloudNodes, mostNodes_));
    const auto clear = [&](std::span<const geo::Direction> places, geo::Angle footprint, std::span<Rgba8> out) {
      io::Result<void> ok;
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
    std::optional<geo::GeoRect> above;
    geo::Angle spacing = planned(input).spacing;
    for (int other = input + 1; other < count_; ++other) {
      const auto both = meeting(planned(input).bounds, planned(other).bounds);
      if (!both) continue;
      above = above ? above->united(*both) : *both;
      spacing = std::max(spacing, planned(other).spacing);
    }
    if (!above) return {};
    const auto laid = [&](std::span<const geo::Direction> places, geo::Angle footprint, std::span<Rgba8> out) {
      return cleanedAbove(input, places, footprint, out);
    };
    auto found = raster::matchColours(samplerOf(input), laid, *above, spacing);
    if (!found) return tl::unexpected(found.error());
    entry(input).match = std::move(*found);
    return {};
  }

  /// The inputs above one, where they are neither cut off nor cloudy.
  io::Result<void> cleanedAbove(int input, std::span<const geo::Direction> places, geo::Angle footprint,
                                std::span<Rgba8> out) {
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
      return inputs_.coloursAt(input, places, footprint, out);
    };
  }

  const BuildPlan& plan_;
  const CleaningOptions& options_;
  ImageryCleaning& cleaning_;
  std::stop_token stop_;
  InputSet inputs_;
  int count_;
  int mostNodes_;
};

io::Result<std::shared_ptr<const ImageryCleaning>> ImageryCleaning::prepare(const BuildPlan& plan,
                                                                            std::stop_token stop) {
  if (!plan.cleaning.asksForAnything()) return nullptr;
  auto cleaning = std::make_shared<ImageryCleaning>();
  cleaning->entries_.resize(plan.inputs.size());
  if (auto ok = Preparation(plan, *cleaning, std::move(stop)).run(); !ok) return tl::unexpected(ok.error());
  return cleaning;
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
