#include <algorithm>
#include <cmath>

#include "pyramid/geometric_error.h"
#include "pyramid/sample_views.h"
#include "pyramid/tile_maker.h"
#include "raster/codec.h"
#include "raster/tile_places.h"

namespace tellurion::pyramid {
namespace {

using raster::HeightStatistics;
using raster::isNoData;
using raster::kGutter;
using raster::kNoData;
using raster::Raster;

/// To the nearest multiple of the step; 0 keeps the height.
float rounded(float height, double step_m) {
  if (step_m == 0.0 || isNoData(height)) return height;
  // As std::nearbyint does, which is a call into the library: what is this large has no digits behind the point.
  constexpr double kWhole = 0x1.8p52;
  const double steps = static_cast<double>(height) / step_m;
  const double whole = std::abs(steps) < 0x1p51 ? (steps + kWhole) - kWhole : steps;
  return static_cast<float>(whole * step_m + 0.0);
}

/// A tile while it is made: samples, and which of them are settled.
struct Canvas {
  Raster<float> samples;
  Raster<float> depths;  ///< as TileDatabase::depths
  std::vector<bool> known;
  int cells;

  explicit Canvas(int tileCells)
      : samples(tileCells + 1 + 2 * kGutter, tileCells + 1 + 2 * kGutter, kNoData),
        depths(samples.width, samples.height, kNoData),
        known(samples.samples.size(), false),
        cells(tileCells) {}
  /// (column, row) without gutter: -1 .. cells + 1.
  void set(int column, int row, float height) {
    samples.at(column + kGutter, row + kGutter) = height;
    known[static_cast<std::size_t>((row + kGutter) * samples.width + column + kGutter)] = true;
  }
};

float sampleOf(const Raster<float>& tile, int column, int row) {
  return tile.at(column + kGutter, row + kGutter);
}

/// Every second sample of a child, and of its depths if it has some.
void takeChild(Canvas& canvas, int quadrant, int level, const Raster<float>& child,
               const std::optional<Raster<float>>& depths) {
  const int half = canvas.cells / 2;
  const int column0 = (quadrant & 1) * half;
  const int row0 = (quadrant >> 1) * half;
  for (int row = 0; row <= half; ++row) {
    for (int column = 0; column <= half; ++column) {
      canvas.set(column0 + column, row0 + row, sampleOf(child, 2 * column, 2 * row));
      if (!depths || !(sampleOf(*depths, 2 * column, 2 * row) < static_cast<float>(level))) continue;
      canvas.depths.at(column0 + column + kGutter, row0 + row + kGutter) = sampleOf(*depths, 2 * column, 2 * row);
    }
  }
}

/// The gutter along half an edge, from the tile of the children's level behind it.
void takeGutter(Canvas& canvas, tiling::Edge edge, int half, const AdjacentTile& adjacent, const Raster<float>& tile) {
  const int cells = canvas.cells;
  for (int i = 0; i <= cells / 2; ++i) {
    const int along = adjacent.reversed ? cells - 2 * i : 2 * i;
    const SampleView view = viewFromEdge(adjacent.tile.record.id, adjacent.edge, along, 2, cells);
    const float height = sampleOf(tile, view.column, view.row);
    const int place = half * cells / 2 + i;
    switch (edge) {
      case tiling::Edge::top:
        canvas.set(place, -1, height);
        break;
      case tiling::Edge::right:
        canvas.set(cells + 1, place, height);
        break;
      case tiling::Edge::bottom:
        canvas.set(place, cells + 1, height);
        break;
      case tiling::Edge::left:
        canvas.set(-1, place, height);
        break;
    }
  }
}

using Heights = std::shared_ptr<const Raster<float>>;

io::Result<Heights> samplesOf(const KnownTile& tile, int cells) {
  if (tile.heights) return tile.heights;
  const int side = sideOf(raster::Kind::elevation, cells);
  auto samples = raster::decodeElevation(tile.record.payload, side, side);
  if (samples) return std::make_shared<const Raster<float>>(std::move(*samples));
  samples.error().where += " " + nameOf(tile.record.id);
  return tl::unexpected(samples.error());
}

/// Takes over the children's samples and statistics.
io::Result<void> takeChildren(const TileTask& task, Canvas& canvas, TileRecord& record) {
  for (std::size_t q = 0; q < 4; ++q) {
    if (!task.children[q]) continue;
    const auto samples = samplesOf(*task.children[q], canvas.cells);
    if (!samples) return tl::unexpected(samples.error());
    takeChild(canvas, static_cast<int>(q), task.id.level, **samples, task.childDepths[q]);
    record.childMask = static_cast<std::uint8_t>(record.childMask | (1u << q));
    record.children[q] = task.children[q]->record.statistics;
  }
  return {};
}

/// Range over the tile and everything below it; of the error, that it is no smaller than a child's, nor than what the
/// samples themselves may be off.
HeightStatistics statisticsOf(const Raster<float>& samples, double maxError_m, const TileRecord& record) {
  HeightStatistics own = raster::ownRangeOf(samples);
  if (!isNoData(own.min_m)) own.error_m = roundedUp(maxError_m);
  for (const HeightStatistics& child : record.children) {
    own.error_m = std::max(own.error_m, child.error_m);
    if (isNoData(child.min_m)) continue;
    own.min_m = isNoData(own.min_m) ? child.min_m : std::min(own.min_m, child.min_m);
    own.max_m = isNoData(own.max_m) ? child.max_m : std::max(own.max_m, child.max_m);
  }
  return own;
}

/// Raises the error to the distance to a tile below. One that is covered by deeper ones, which are compared too, is
/// left out; one of the last level that is compared adds its own error, the others what their samples may be off.
io::Result<void> raiseError(const Canvas& canvas, const KnownTile& tile, double spacing_m, double maxError_m,
                            TileRecord& record) {
  constexpr std::uint8_t kAllChildren = 15;
  const TileRecord& below = tile.record;
  const bool isLast = below.id.level - record.id.level == kComparedLevels;
  if (below.childMask == kAllChildren && !isLast) return {};
  const auto samplesBelow = samplesOf(tile, canvas.cells);
  if (!samplesBelow) return tl::unexpected(samplesBelow.error());
  HeightStatistics& own = record.statistics;
  const ErrorScale scale{.spacing_m = spacing_m,
                         .missing_m = static_cast<double>(own.max_m) - static_cast<double>(own.min_m)};
  const double distance = distanceToDescendant(record.id, canvas.samples, below.id, **samplesBelow, scale);
  const double beyond = isLast ? static_cast<double>(below.statistics.error_m) : maxError_m;
  own.error_m = std::max(own.error_m, roundedUp(distance + beyond));
  return {};
}

io::Result<void> summarise(const TileTask& task, const Canvas& canvas, double spacing_m, double maxError_m,
                           TileRecord& record) {
  record.statistics = statisticsOf(canvas.samples, maxError_m, record);
  if (isNoData(record.statistics.min_m)) return {};
  for (const auto& child : task.children) {
    if (!child) continue;
    if (auto ok = raiseError(canvas, *child, spacing_m, maxError_m, record); !ok) return ok;
  }
  for (const KnownTile& below : task.deeper) {
    if (auto ok = raiseError(canvas, below, spacing_m, maxError_m, record); !ok) return ok;
  }
  return {};
}

io::Result<void> takeGutters(const TileTask& task, Canvas& canvas) {
  for (const tiling::Edge edge : tiling::kEdges) {
    for (int half = 0; half < 2; ++half) {
      const auto& adjacent = task.beyond[static_cast<std::size_t>(edge)][static_cast<std::size_t>(half)];
      if (!adjacent) continue;
      const auto samples = samplesOf(adjacent->tile, canvas.cells);
      if (!samples) return tl::unexpected(samples.error());
      takeGutter(canvas, edge, half, *adjacent, **samples);
    }
  }
  return {};
}

}  // namespace

io::Result<void> TileMaker::sampleOpenHeights(const TileTask& task, const std::vector<bool>& known,
                                              Raster<float>& samples, Raster<float>& depths) {
  if (!plan_.fills()) {
    const auto open = openSamples(plan_.tiling(), task.id, raster::Kind::elevation, plan_.meta.tileCells, known);
    std::vector<float> heights(open.size(), kNoData);
    if (auto ok = inputs_.heights(task.inputs, task.id, open, heights); !ok) return ok;
    for (std::size_t i = 0; i < open.size(); ++i)
      samples.samples[open[i]] = rounded(heights[i], plan_.meta.heightStep_m);
    return {};
  }
  const raster::OpenPlaces open =
      openPlaces(plan_.tiling(), task.id, raster::Kind::elevation, plan_.meta.tileCells, known);
  if (open.indices.empty()) return {};
  const auto ground = fill_.heights(task.id, task.inputs, open);
  if (!ground) return tl::unexpected(ground.error());
  for (std::size_t i = 0; i < open.indices.size(); ++i) {
    samples.samples[open.indices[i]] = rounded(ground->heights_m[i], plan_.meta.heightStep_m);
    const int depth = ground->depths[i];
    if (depth >= 0 && depth < task.id.level) depths.samples[open.indices[i]] = static_cast<float>(depth);
  }
  return {};
}

TileMaker::Made TileMaker::makeElevation(const TileTask& task) {
  Canvas canvas(plan_.meta.tileCells);
  TileRecord record{.id = task.id, .statistics = {}, .childMask = 0, .children = {}, .payload = {}, .depths = {}};
  if (auto ok = takeChildren(task, canvas, record); !ok) return tl::unexpected(ok.error());
  if (auto ok = takeGutters(task, canvas); !ok) return tl::unexpected(ok.error());
  if (auto ok = sampleOpenHeights(task, canvas.known, canvas.samples, canvas.depths); !ok) {
    return tl::unexpected(ok.error());
  }
  const double spacing_m = plan_.tiling().metrics(task.id.level).largestEdge.radians() / plan_.meta.tileCells *
                           plan_.meta.body.ellipsoid.semiMajorAxis_m();
  if (auto ok = summarise(task, canvas, spacing_m, plan_.meta.maxError_m, record); !ok)
    return tl::unexpected(ok.error());
  if (isNoData(record.statistics.min_m) && record.childMask == 0) return std::optional<KnownTile>{};
  record.payload = raster::encodeElevation(canvas.samples, plan_.meta.heightStep_m);
  record.depths = encodedDepths(canvas.depths);
  return std::optional(KnownTile{.record = std::move(record),
                                 .heights = std::make_shared<const Raster<float>>(std::move(canvas.samples)),
                                 .pixels = nullptr});
}

}  // namespace tellurion::pyramid
