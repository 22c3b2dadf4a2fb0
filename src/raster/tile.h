#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "raster/raster.h"

namespace tellurion::raster {

enum class Kind : std::uint8_t { elevation, imagery };
std::optional<Kind> kindByName(std::string_view name);
std::string_view nameOf(Kind kind);

inline constexpr int kElevationCells = 64;  ///< default cells a side of an elevation tile: 65 samples
inline constexpr int kImageryPixels = 256;  ///< default pixels a side of an imagery tile
inline constexpr int kGutter = 1;           ///< samples around every tile that belong to its neighbours

/// What is known of a tile's heights. NaN minimum and maximum: no data at all.
struct HeightStatistics {
  float min_m = kNoData;
  float max_m = kNoData;
  /// Geometric error: the largest vertical distance in metres between the bilinear surface through this tile's samples
  /// and the finest data below it; without children 0, or what the samples themselves may be off. The body's curvature
  /// is not in it.
  float error_m = 0.0f;
};

/// Lowest and highest of an elevation tile's samples, gutter not counted; the error is 0.
HeightStatistics ownRangeOf(const Raster<float>& samples);

/// Vertex-registered: sample (c, r), gutter included, lies at tile-local s = (c - 1) / cells, t = (r - 1) / cells.
/// Neighbours hold the same values on their shared edge and, through the gutter, one sample of each other. The four
/// corners of the gutter carry no promise.
struct ElevationTile {
  Raster<float> samples;  ///< (cells + 3) x (cells + 3), metres, NaN is NODATA
  int cells() const { return samples.width - 1 - 2 * kGutter; }
};

/// Pixel-registered: the centre of pixel (c, r), gutter included, lies at s = (c - 0.5) / size, t = (r - 0.5) / size.
struct ImageryTile {
  Raster<Rgba8> pixels;  ///< (size + 2) x (size + 2)
  int size() const { return pixels.width - 2 * kGutter; }
};

using TilePayload = std::variant<ElevationTile, ImageryTile>;

/// A tile and what it tells of its children, so that a cut can be planned without loading them.
struct SourceTile {
  TilePayload payload;
  HeightStatistics statistics;                 ///< elevation only
  std::uint8_t childMask = 0;                  ///< bit q: the child in quadrant q is stored
  std::array<HeightStatistics, 4> children{};  ///< elevation only; of the stored children
};

}  // namespace tellurion::raster
