#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>

#include "geo/geo_rect.h"
#include "io/failure.h"
#include "pyramid/map_tiles.h"
#include "raster/codec.h"

namespace tellurion::pyramid {

enum class ExportFormat : std::uint8_t { geotiff, cog, geopackage, mbtiles, xyz, quantizedMesh };
std::optional<ExportFormat> exportFormatByName(std::string_view name);
std::string_view nameOf(ExportFormat format);

struct ExportOptions {
  std::filesystem::path input;  ///< a finished tile database
  /// A file or, for xyz and quantizedMesh, a folder. Made in OUTPUT.part and renamed at the end, so it is whole or not
  /// there.
  std::filesystem::path output;
  ExportFormat format = ExportFormat::geotiff;
  /// Tile sets: the zooms to write; left out: from 0 to where pixels are as fine as the database's. Rasters: pixels are
  /// as fine as the database's level maxLevel; minLevel is refused.
  std::optional<int> minLevel;
  std::optional<int> maxLevel;
  /// Only what lies in it; left out: all that has data. Rasters end at the pixels that hold its edges, tile sets at the
  /// tiles.
  std::optional<geo::GeoRect> region;
  raster::ImageFormat pixels = raster::ImageFormat::png;  ///< imagery; PNG is without loss, and so is such a COG
  int quality = 85;                                       ///< 1..100, of JPEG and WebP
  MapScheme scheme = MapScheme::mercator;                 ///< xyz
  bool replace = false;                                   ///< what is there under the output's name
  int jobs = 0;                                           ///< worker threads; 0: one for each core
};

/// Of the tiles or windows to make; `total` is exact but for tiles that turn out empty. After them, where a finished
/// file is made of them, `done` and `total` are thousandths of that.
struct ExportProgress {
  std::uint64_t done = 0;
  std::uint64_t total = 0;
  bool isFinishing = false;
};
using ExportProgressSink = std::function<void(const ExportProgress&)>;  ///< on the caller's thread

struct ExportReport {
  std::uint64_t tiles = 0;  ///< tile sets: tiles written
  int minZoom = 0;
  int maxZoom = 0;
  int width = 0;  ///< rasters: pixels
  int height = 0;
  double step_degrees = 0.0;  ///< rasters: a pixel's side
  std::uint64_t bytes = 0;    ///< of all that was written
};

/// Writes a database's data in a format of others, resampled where its tiling is not theirs: each pixel is what a query
/// of the database says at its centre, from the level that its size asks for. All cores work; memory is bounded
/// whatever the size. A failure, or a stop asked for through `stop` (cancelled), leaves the output as it was.
io::Result<ExportReport> exportPyramid(const ExportOptions& options, const ExportProgressSink& progress = {},
                                       std::stop_token stop = {});

}  // namespace tellurion::pyramid
