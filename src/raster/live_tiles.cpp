#include "raster/live_tiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tellurion::raster {
namespace {

constexpr double kLeastShare = 1.0 / 256.0;
constexpr double kMostShare = 0.5;

/// The largest second difference along rows and columns, where all three samples have data.
double roughness_m(const Raster<float>& samples) {
  float largest = 0.0f;
  const auto look = [&](float before, float here, float after) {
    const float bend = std::abs(before - 2.0f * here + after);
    if (bend > largest) largest = bend;  // never true of NaN
  };
  for (int row = 1; row + 1 < samples.height; ++row) {
    for (int col = 1; col + 1 < samples.width; ++col) {
      look(samples.at(col - 1, row), samples.at(col, row), samples.at(col + 1, row));
      look(samples.at(col, row - 1), samples.at(col, row), samples.at(col, row + 1));
    }
  }
  return static_cast<double>(largest);
}

}  // namespace

int usualCells(Kind kind) {
  return kind == Kind::elevation ? kElevationCells : kImageryPixels;
}

int levelOfSpacing(const tiling::Tiling& tiling, int cells, geo::Angle spacing) {
  // A raster is not blown up by a level only because its spacing is a hair finer than the level's.
  constexpr double kSlack = 1.01;
  int level = 0;
  while (level < tiling::kMaxLevel && tiling.metrics(level).largestEdge / cells > spacing * kSlack)
    ++level;
  return level;
}

TilePresence livePresence(const tiling::TileId& id, const std::function<bool(const tiling::TileId&)>& mayTouch,
                          const std::function<bool(const tiling::TileId&)>& isCoarse) {
  TilePresence presence;
  presence.stored = id.level == 0 || (id.level <= tiling::kMaxLevel && isCoarse(id.parent()));
  for (tiling::TileId at = id; presence.stored && at.level > 0; at = at.parent())
    presence.stored = mayTouch(at);
  if (!presence.stored || id.level >= tiling::kMaxLevel || !isCoarse(id)) return presence;
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    if (mayTouch(id.child(quadrant))) presence.childMask |= static_cast<std::uint8_t>(1u << quadrant);
  }
  return presence;
}

HeightStatistics estimatedStatistics(const Raster<float>& samples, double spacing_m, int levelsBelow) {
  HeightStatistics known = ownRangeOf(samples);
  if (levelsBelow <= 0) return known;
  if (isNoData(known.min_m)) {
    return {.min_m = 0.0f, .max_m = 0.0f, .error_m = static_cast<float>(kMostShare * spacing_m)};
  }
  const double sum = 1.0 - std::exp2(-levelsBelow);
  const double error_m = 0.5 * roughness_m(samples) * sum;
  known.error_m = static_cast<float>(std::clamp(error_m, kLeastShare * spacing_m, kMostShare * spacing_m));
  return known;
}

HeightStatistics estimatedOfChild(const HeightStatistics& tile, int levelsBelow) {
  return {.min_m = tile.min_m - tile.error_m,
          .max_m = tile.max_m + tile.error_m,
          .error_m = levelsBelow > 1 ? 0.5f * tile.error_m : 0.0f};
}

SourceTile liveTile(Raster<float> samples, std::uint8_t childMask, const tiling::TileId& id,
                    const TileSourceInfo& info) {
  const double spacing_m = tiling::Tiling(info.scheme).metrics(id.level).meanEdge.radians() / info.tileCells *
                           info.body.ellipsoid.semiMajorAxis_m();
  const int levelsBelow = childMask != 0 ? std::max(1, info.maxLevel - id.level) : 0;
  SourceTile tile;
  tile.statistics = estimatedStatistics(samples, spacing_m, levelsBelow);
  tile.childMask = childMask;
  for (std::size_t q = 0; q < tile.children.size(); ++q) {
    if (((childMask >> q) & 1) != 0) tile.children[q] = estimatedOfChild(tile.statistics, levelsBelow);
  }
  tile.payload = ElevationTile{std::move(samples)};
  return tile;
}

SourceTile liveTile(Raster<Rgba8> pixels, std::uint8_t childMask) {
  const int last = pixels.width - 1;
  for (const int row : {0, last}) {
    for (const int column : {0, last}) {
      pixels.at(column, row) = pixels.at(std::clamp(column, 1, last - 1), std::clamp(row, 1, last - 1));
    }
  }
  SourceTile tile;
  tile.childMask = childMask;
  tile.payload = ImageryTile{std::move(pixels)};
  return tile;
}

}  // namespace tellurion::raster
