#include "raster/live_tiles.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raster/grid_geometry.h"

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

int levelOfSpacing(const tiling::Tiling& tiling, int cells, geo::Angle spacing, Kind kind) {
  // A raster is not blown up by a level only because its spacing is a hair finer than the level's.
  constexpr double kSlack = 1.01;
  int level = 0;
  const auto spacingOf = [&](int at) {
    const geo::Angle longest = tiling.metrics(at).largestEdge / cells;
    return kind == Kind::imagery ? std::min(longest, sampleSpacing(tiling, at, cells)) : longest;
  };
  while (level < tiling::kMaxLevel && spacingOf(level) > spacing * kSlack)
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

double departureOfChild(const Raster<float>& tile, int quadrant, const Raster<float>& child) {
  const int cells = tile.width - 3;  // a sample more than cells, and a gutter on both sides
  const int firstCol = (quadrant & 1) * cells, firstRow = (quadrant >> 1) * cells;  // in cells of the child
  const auto known = [&](int col, int row) { return static_cast<double>(tile.at(col + 1, row + 1)); };
  double largest = -1.0;
  for (int row = 0; row <= cells; ++row) {
    for (int col = 0; col <= cells; ++col) {
      const int x = firstCol + col, y = firstRow + row;
      const int right = (x + 1) / 2, lower = (y + 1) / 2;
      const double surface_m =
          0.25 * (known(x / 2, y / 2) + known(right, y / 2) + known(x / 2, lower) + known(right, lower));
      const double off_m = std::abs(surface_m - static_cast<double>(child.at(col + 1, row + 1)));
      if (off_m > largest) largest = off_m;  // never true of NaN
    }
  }
  return largest;
}

SourceTile liveTile(Raster<float> samples, std::uint8_t childMask, const tiling::TileId& id, const TileSourceInfo& info,
                    std::optional<double> departure_m) {
  const double spacing_m = tiling::Tiling(info.scheme).metrics(id.level).meanEdge.radians() / info.tileCells *
                           info.body.ellipsoid.semiMajorAxis_m();
  const int levelsBelow = childMask != 0 ? std::max(1, info.maxLevel - id.level) : 0;
  SourceTile tile;
  tile.statistics = estimatedStatistics(samples, spacing_m, levelsBelow);
  if (departure_m && levelsBelow > 0) {
    const double least_m = levelsBelow > 1 ? kLeastShare * spacing_m : 0.0;
    const double error_m = std::max(*departure_m * 2.0 * (1.0 - std::exp2(-levelsBelow)), least_m);
    tile.statistics.error_m = static_cast<float>(error_m);
  }
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
