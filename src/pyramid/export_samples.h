#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "pyramid/colour_query.h"
#include "pyramid/height_query.h"
#include "pyramid/pyramid_reader.h"

namespace tellurion::pyramid {

/// Places in rows of one latitude and columns of one longitude, as the formats of others have them.
struct PlaceGrid {
  std::vector<double> longitudes_degrees;
  std::vector<double> latitudes_degrees;
  std::vector<double> steps_degrees;  ///< of each row: the ground's angle between its places, where it is smallest
};

/// A part of the body that a database may have data on.
struct CoveredRect {
  geo::GeoRect rect;
  float min_m = raster::kNoData;  ///< elevation: the lowest and highest stored on it
  float max_m = raster::kNoData;
};

/// What a finished database says at the places of grids. Thread-safe.
class ExportSamples {
 public:
  static io::Result<std::unique_ptr<const ExportSamples>> open(const std::filesystem::path& path);

  const raster::TileSourceInfo& info() const { return source_->info(); }
  /// The mean angle between the samples of a level, degrees.
  double spacing_degrees(int level) const;
  /// The coarsest level whose samples are no more than a tenth farther apart than `step_degrees`, else the deepest.
  int levelFor(double step_degrees) const;

  /// NaN (0 of coverage) where there is no data. Each row is read from the level that its step asks for, so that
  /// nothing finer flickers through, but for nothing deeper than `deepest`; between samples bilinear.
  io::Result<raster::Raster<float>> heights(const PlaceGrid& grid, int deepest) const;
  io::Result<raster::Raster<raster::Rgba8>> colours(const PlaceGrid& grid, int deepest) const;

  /// Costs a walk over the table of tiles.
  io::Result<std::uint64_t> storedTiles() const;

  /// Rectangles that hold all that is stored, some thousands at most: those of tiles of one level or, where the data
  /// ends, of less deep ones.
  io::Result<std::vector<CoveredRect>> coverage() const;

 private:
  ExportSamples() = default;
  std::shared_ptr<const PyramidReader> source_;
  std::optional<HeightQuery> heights_;
  std::optional<ColourQuery> colours_;
};

}  // namespace tellurion::pyramid
