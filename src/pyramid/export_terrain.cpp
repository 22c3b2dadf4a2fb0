#include <algorithm>
#include <array>
#include <utility>

#include "pyramid/export_run.h"
#include "pyramid/quantized_mesh.h"
#include "pyramid/terrain_set.h"

namespace tellurion::pyramid {
namespace {

/// What a first walk over the tiles tells.
struct Survey {
  std::uint64_t tiles = 0;
  std::vector<double> steps_m;    ///< of each zoom
  std::array<bool, 2> hasRoot{};  ///< which tiles of zoom 0 are among them
};

/// Tiles of a zoom share a step, so it is that of the one with the largest range; height 0 stands for NODATA.
Survey surveyed(const MapExtent& extent, const std::stop_token& stop) {
  struct Range {
    double lowest_m = 0.0;
    double highest_m = 0.0;
  };
  std::vector<Range> ranges(static_cast<std::size_t>(extent.maxZoom) + 1);
  Survey survey;
  MapWalk walk(extent);
  for (auto step = walk.next(); step && !stop.stop_requested(); step = walk.next()) {
    ++survey.tiles;
    if (step->tile.zoom == 0) survey.hasRoot[static_cast<std::size_t>(step->tile.x)] = true;
    Range& range = ranges[static_cast<std::size_t>(step->tile.zoom)];
    for (const CoveredRect& rect : *step->covered) {
      if (raster::isNoData(rect.min_m)) continue;
      range.lowest_m = std::min(range.lowest_m, static_cast<double>(rect.min_m));
      range.highest_m = std::max(range.highest_m, static_cast<double>(rect.max_m));
    }
  }
  for (const Range& range : ranges)
    survey.steps_m.push_back(terrainStep_m(range.lowest_m, range.highest_m));
  return survey;
}

io::Result<MapExtent> extentOf(const ExportRun& run) {
  auto covered = run.samples.coverage();
  if (!covered) return tl::unexpected(covered.error());
  const double spacing_degrees = run.samples.spacing_degrees(run.samples.info().maxLevel);
  MapExtent extent;
  extent.scheme = MapScheme::geodetic;
  extent.maxZoom =
      run.options.maxLevel.value_or(zoomFor(MapScheme::geodetic, spacing_degrees * kTerrainCells / kMapTilePixels));
  extent.covered = std::move(*covered);
  extent.region = run.options.region;
  return extent;
}

io::Result<MadeTile> made(const ExportRun& run, const MapTile& tile, double step_m) {
  const auto heights = run.samples.heights(terrainPlaces(tile), run.samples.info().maxLevel);
  if (!heights) return tl::unexpected(heights.error());
  // Readers begin at both tiles of zoom 0, whatever is on them.
  const bool isEmpty = tile.zoom > 0 && std::ranges::all_of(heights->samples, raster::isNoData);
  if (isEmpty) return MadeTile{.tile = tile, .bytes = {}};
  return MadeTile{.tile = tile,
                  .bytes = encodeQuantizedMesh(*heights, tile, run.samples.info().body.ellipsoid, step_m)};
}

}  // namespace

io::Result<ExportReport> exportTerrain(const ExportRun& run, ExportPlace& place) {
  const auto extent = extentOf(run);
  if (!extent) return tl::unexpected(extent.error());
  const auto most = mostUnasked(run);
  if (!most) return tl::unexpected(most.error());
  if (countOf(*extent, *most, run.stop) == *most) return tl::unexpected(tooMagnified(run, *most));
  const Survey survey = surveyed(*extent, run.stop);
  if (run.stop.stop_requested()) return tl::unexpected(run.stopped());
  const std::filesystem::path path = place.inside("terrain");
  auto set = createTerrainFolder(path, {.scheme = MapScheme::geodetic,
                                        .maxZoom = extent->maxZoom,
                                        .bounds = run.options.region.value_or(run.samples.info().bounds)});
  if (!set) return tl::unexpected(set.error());
  const MakeTile make = [&](const MapTile& tile) {
    return made(run, tile, survey.steps_m[static_cast<std::size_t>(tile.zoom)]);
  };
  auto written = writeTiles(run, *extent, survey.tiles, make, **set);
  if (!written) return tl::unexpected(written.error());
  for (std::int64_t x = 0; x < 2; ++x) {
    if (survey.hasRoot[static_cast<std::size_t>(x)]) continue;
    const auto root = make({.zoom = 0, .x = x, .y = 0});
    if (!root) return tl::unexpected(root.error());
    if (auto ok = (*set)->put(root->tile, root->bytes); !ok) return tl::unexpected(ok.error());
    ++*written;
  }
  if (auto ok = (*set)->finish(); !ok) return tl::unexpected(ok.error());
  if (auto ok = place.publish(path); !ok) return tl::unexpected(ok.error());
  return ExportReport{.tiles = *written, .minZoom = 0, .maxZoom = extent->maxZoom};
}

}  // namespace tellurion::pyramid
