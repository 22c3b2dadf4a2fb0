#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "raster/tile_source.h"
#include "tiling/tiling.h"

namespace tellurion::scene {

/// A number in [0, 1) that looks random and depends on the bits of a place alone.
inline double hashOf(const geo::Direction& d, std::uint64_t seed) {
  std::uint64_t h = seed;
  for (const double v : {d.n.x, d.n.y, d.n.z}) {
    h = (h ^ std::bit_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15u;
    h ^= h >> 29;
  }
  h *= 0xbf58476d1ce4e5b9u;
  return static_cast<double>((h ^ (h >> 31)) >> 11) * 0x1p-53;
}

/// Smooth hills, a few kilometres high, on all scales down to kilometres.
inline double hillsAt(const geo::Direction& d) {
  double height = 0.0;
  double size = 2000.0;
  for (double frequency = 3.0; frequency < 3000.0; frequency *= 2.7, size *= 0.45) {
    height +=
        size * std::sin(frequency * d.n.x + 1.3) * std::sin(frequency * d.n.y + 0.4) * std::cos(frequency * d.n.z);
  }
  return height;
}

/// A planet out of functions, as a TileSource with what tests need: which tiles are stored, delays, failures, a log.
class ProceduralSource final : public raster::TileSource {
 public:
  using Stored = std::function<bool(const tiling::TileId&)>;
  using Height = std::function<double(const geo::Direction&)>;

  ProceduralSource(raster::Kind kind, tiling::Scheme scheme, int maxLevel, geo::Body body = geo::earth())
      : tiling_(scheme) {
    info_ = {.name = "procedural", .kind = kind, .scheme = scheme, .body = std::move(body), .maxLevel = maxLevel};
    info_.tileCells = kind == raster::Kind::elevation ? raster::kElevationCells : raster::kImageryPixels;
    stored = [](const tiling::TileId&) { return true; };
    height = hillsAt;
  }

  Stored stored;  ///< closed under parents; levels beyond maxLevel are never asked
  Height height;
  double heightBound_m = 4000.0;
  std::function<double(int level)> error_m;  ///< that tiles state; otherwise what suits hillsAt
  /// Lowest and highest, which tiles state of themselves and of all below; otherwise of their own samples.
  std::optional<std::pair<double, double>> heightRange_m;
  std::set<tiling::TileId> failing;
  std::function<void(const tiling::TileId&)> delay;

  void setBounds(const geo::GeoRect& bounds) { info_.bounds = bounds; }
  void setNested(bool isNested) { info_.isNested = isNested; }

  const raster::TileSourceInfo& info() const override { return info_; }

  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    {
      const std::lock_guard lock(mutex_);
      ++requests_[id];
    }
    if (delay) delay(id);
    if (failing.count(id) != 0)
      return io::fail(io::Failure::Code::ioError, "made to fail",
                      info_.kind == raster::Kind::elevation ? "heights" : "colours");
    if (id.level > info_.maxLevel || !stored(id)) return std::optional<raster::SourceTile>();
    raster::SourceTile tile;
    for (int q = 0; q < 4; ++q) {
      if (id.level < info_.maxLevel && stored(id.child(q)))
        tile.childMask = static_cast<std::uint8_t>(tile.childMask | (1 << q));
    }
    if (info_.kind == raster::Kind::elevation) {
      fillHeights(id, tile);
    } else {
      tile.payload =
          raster::ImageryTile{.pixels = raster::Raster<raster::Rgba8>(
                                  258, 258, {std::uint8_t(40 * id.root), 100, std::uint8_t(20 * id.level), 255})};
    }
    return std::optional(std::move(tile));
  }

  std::map<tiling::TileId, int> requests() const {
    const std::lock_guard lock(mutex_);
    return requests_;
  }

 private:
  void fillHeights(const tiling::TileId& id, raster::SourceTile& tile) const {
    const int cells = info_.tileCells;
    raster::Raster<float> samples(cells + 3, cells + 3, raster::kNoData);
    tile.statistics = {.min_m = 1e9f, .max_m = -1e9f};
    for (int row = -1; row <= cells + 1; ++row) {
      for (int col = -1; col <= cells + 1; ++col) {
        const auto place = tiling_.wrapped(tiling::rootPointIn(id, double(col) / cells, double(row) / cells));
        if (!place) continue;
        const auto h = static_cast<float>(height(tiling_.direction(*place)));
        samples.at(col + 1, row + 1) = h;
        if (raster::isNoData(h)) continue;
        tile.statistics.min_m = std::min(tile.statistics.min_m, h);
        tile.statistics.max_m = std::max(tile.statistics.max_m, h);
      }
    }
    if (heightRange_m) {
      tile.statistics.min_m = static_cast<float>(heightRange_m->first);
      tile.statistics.max_m = static_cast<float>(heightRange_m->second);
    }
    const auto bound = static_cast<float>(heightBound_m);
    if (tile.childMask != 0) {
      tile.statistics.error_m =
          error_m ? static_cast<float>(error_m(id.level)) : 2.0f * bound / static_cast<float>(1u << (2 * id.level));
    }
    tile.children.fill({.min_m = -bound, .max_m = bound, .error_m = 0.0f});
    tile.payload = raster::ElevationTile{.samples = std::move(samples)};
  }

  tiling::Tiling tiling_;
  raster::TileSourceInfo info_;
  mutable std::mutex mutex_;
  mutable std::map<tiling::TileId, int> requests_;
};

}  // namespace tellurion::scene
