#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <stop_token>
#include <thread>
#include <vector>

#include "pyramid/export.h"
#include "pyramid/export_place.h"
#include "pyramid/export_samples.h"
#include "pyramid/ordered_work.h"
#include "pyramid/tile_set.h"

namespace tellurion::pyramid {

/// What every kind of export works with. One thread only.
struct ExportRun {
  const ExportOptions& options;
  const ExportSamples& samples;
  const ExportProgressSink& progress;
  std::stop_token stop;

  int jobs() const {
    return options.jobs > 0 ? options.jobs : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }
  /// Pieces of work that may wait at a time: what bounds memory.
  std::size_t window() const { return 2 * static_cast<std::size_t>(jobs()) + 2; }
  io::Failure stopped() const {
    return {io::Failure::Code::cancelled, "stopped; nothing was written", options.output.string()};
  }
};

/// What an export may take of tiles of the database's own size while nobody said how deep it is to go: beyond it, most
/// of them would be coarse data magnified to the depth of a small fine part.
io::Result<std::uint64_t> mostUnasked(const ExportRun& run);
/// What to say of more.
io::Failure tooMagnified(const ExportRun& run, std::uint64_t most);

/// A raster in longitude and latitude: GeoTIFF, COG, GeoPackage.
io::Result<ExportReport> exportRaster(const ExportRun& run, ExportPlace& place);

/// A set of map tiles: MBTiles, XYZ.
io::Result<ExportReport> exportTiles(const ExportRun& run, ExportPlace& place);

/// A folder of quantized-mesh tiles.
io::Result<ExportReport> exportTerrain(const ExportRun& run, ExportPlace& place);

struct MadeTile {
  MapTile tile;
  std::vector<std::byte> bytes;  ///< empty: there is nothing, and no tile
};
using MakeTile = std::function<io::Result<MadeTile>(const MapTile&)>;  ///< on any thread

/// Makes all tiles of an extent, `total` of them, on workers, and puts those that hold something into a set; how many.
/// Fails where none does.
io::Result<std::uint64_t> writeTiles(const ExportRun& run, const MapExtent& extent, std::uint64_t total,
                                     const MakeTile& make, TileSet& set);

/// How work on many pieces goes on: next(work) hands in the next piece and says whether there was one, take(result)
/// takes what came out, in order.
template <class Result, class Next, class Take>
io::Result<void> inOrder(const ExportRun& run, std::uint64_t total, const Next& next, const Take& take) {
  constexpr std::chrono::milliseconds kReportInterval{100};
  auto lastReport = std::chrono::steady_clock::now() - kReportInterval;
  OrderedWork<Result> work(run.jobs(), run.window());
  std::uint64_t done = 0;
  bool isExhausted = false;
  while (!isExhausted || !work.isEmpty()) {
    if (run.stop.stop_requested()) return tl::unexpected(run.stopped());
    if (!isExhausted && !work.isFull()) {
      isExhausted = !next(work);
      continue;
    }
    if (auto ok = take(work.pop()); !ok) return ok;
    ++done;
    const auto now = std::chrono::steady_clock::now();
    if (!run.progress || now - lastReport < kReportInterval) continue;
    lastReport = now;
    run.progress({.done = done, .total = std::max(total, done)});
  }
  return {};
}

}  // namespace tellurion::pyramid
