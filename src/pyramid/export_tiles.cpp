#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "pyramid/export_run.h"
#include "pyramid/tile_set.h"

namespace tellurion::pyramid {
namespace {

using Code = io::Failure::Code;

io::Result<MadeTile> madePicture(const ExportRun& run, MapScheme scheme, const MapTile& tile) {
  const auto pixels = run.samples.colours(pixelsOf(scheme, tile), run.samples.info().maxLevel);
  if (!pixels) return tl::unexpected(pixels.error());
  const bool isEmpty = std::ranges::all_of(pixels->samples, [](const raster::Rgba8& p) { return p.a == 0; });
  if (isEmpty) return MadeTile{.tile = tile, .bytes = {}};
  auto bytes = raster::encodeImage(*pixels, run.options.pixels, run.options.quality);
  if (!bytes) return tl::unexpected(bytes.error());
  return MadeTile{.tile = tile, .bytes = std::move(*bytes)};
}

io::Result<MapExtent> extentOf(const ExportRun& run) {
  auto covered = run.samples.coverage();
  if (!covered) return tl::unexpected(covered.error());
  const bool isMbtiles = run.options.format == ExportFormat::mbtiles;
  const raster::TileSourceInfo& info = run.samples.info();
  MapExtent extent;
  extent.scheme = isMbtiles ? MapScheme::mercator : run.options.scheme;
  extent.maxZoom = run.options.maxLevel.value_or(zoomFor(extent.scheme, run.samples.spacing_degrees(info.maxLevel)));
  extent.minZoom = run.options.minLevel.value_or(0);
  extent.covered = std::move(*covered);
  extent.region = run.options.region;
  if (extent.minZoom <= extent.maxZoom) return extent;
  return io::fail(Code::invalidArgument,
                  fmt::format("pixels of zoom {} are as fine as the database already; for finer ones give the last "
                              "zoom too",
                              extent.maxZoom),
                  info.name);
}

}  // namespace

io::Result<std::uint64_t> writeTiles(const ExportRun& run, const MapExtent& extent, std::uint64_t total,
                                     const MakeTile& make, TileSet& set) {
  MapWalk walk(extent);
  std::uint64_t written = 0;
  const auto next = [&](OrderedWork<io::Result<MadeTile>>& work) {
    const auto step = walk.next();
    if (step) work.push([&make, tile = step->tile] { return make(tile); });
    return step.has_value();
  };
  const auto take = [&](const io::Result<MadeTile>& tile) -> io::Result<void> {
    if (!tile) return tl::unexpected(tile.error());
    if (tile->bytes.empty()) return {};
    ++written;
    return set.put(tile->tile, tile->bytes);
  };
  if (auto ok = inOrder<io::Result<MadeTile>>(run, total, next, take); !ok) return tl::unexpected(ok.error());
  if (written > 0) return written;
  return io::fail(Code::invalidArgument, "has no data there: nothing to export; 'tellurion info' tells where it has",
                  run.samples.info().name);
}

io::Result<ExportReport> exportTiles(const ExportRun& run, ExportPlace& place) {
  const auto extent = extentOf(run);
  if (!extent) return tl::unexpected(extent.error());
  const auto most = mostUnasked(run);
  if (!most) return tl::unexpected(most.error());
  const std::uint64_t total = countOf(*extent, *most, run.stop);
  if (run.stop.stop_requested()) return tl::unexpected(run.stopped());
  if (total == *most) return tl::unexpected(tooMagnified(run, *most));
  const bool isMbtiles = run.options.format == ExportFormat::mbtiles;
  const std::filesystem::path path = place.inside(isMbtiles ? "tiles.mbtiles" : "tiles");
  const TileSetFacts facts{.name = run.options.output.stem().string(),
                           .scheme = extent->scheme,
                           .format = run.options.pixels,
                           .minZoom = extent->minZoom,
                           .maxZoom = extent->maxZoom,
                           .bounds = run.options.region.value_or(run.samples.info().bounds)};
  ExportReport report{.minZoom = extent->minZoom, .maxZoom = extent->maxZoom};
  {  // the set is closed before it is renamed
    auto set = isMbtiles ? createMbtiles(path, facts) : createTileFolder(path, facts);
    if (!set) return tl::unexpected(set.error());
    const MakeTile make = [&](const MapTile& tile) { return madePicture(run, extent->scheme, tile); };
    const auto written = writeTiles(run, *extent, total, make, **set);
    if (!written) return tl::unexpected(written.error());
    report.tiles = *written;
    if (auto ok = (*set)->finish(); !ok) return tl::unexpected(ok.error());
  }
  if (auto ok = place.publish(path); !ok) return tl::unexpected(ok.error());
  return report;
}

}  // namespace tellurion::pyramid
