#include "pyramid/elevation_promises_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

#include "pyramid/synthetic_rasters_test.h"

namespace tellurion::pyramid::testing {
namespace {

using raster::kGutter;
using tiling::Edge;
using tiling::TileId;

constexpr int kCells = raster::kElevationCells;

bool sameBits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

/// The sample `depth` steps in from an edge (negative: in the gutter), `along` it with u or v.
float sampleAtEdge(const raster::Raster<float>& tile, Edge edge, int along, int depth) {
  const int near = kGutter + depth;
  const int far = kGutter + kCells - depth;
  const int place = kGutter + along;
  switch (edge) {
    case Edge::top:
      return tile.at(place, near);
    case Edge::right:
      return tile.at(far, place);
    case Edge::bottom:
      return tile.at(place, far);
    case Edge::left:
      return tile.at(near, place);
  }
  return raster::kNoData;
}

/// The bilinear surface of a tile at a place inside a descendant; NaN where one of its corners has no data.
double surfaceAt(const raster::Raster<float>& tile, double s, double t) {
  const double x = s * kCells;
  const double y = t * kCells;
  const int c = std::min(static_cast<int>(x), kCells - 1);
  const int r = std::min(static_cast<int>(y), kCells - 1);
  const auto h = [&](int i, int j) { return static_cast<double>(tile.at(kGutter + c + i, kGutter + r + j)); };
  const double fx = x - c;
  const double fy = y - r;
  const double top = fx == 0.0 ? h(0, 0) : h(0, 0) * (1 - fx) + h(1, 0) * fx;
  if (fy == 0.0) return top;
  const double bottom = fx == 0.0 ? h(0, 1) : h(0, 1) * (1 - fx) + h(1, 1) * fx;
  return top * (1 - fy) + bottom * fy;
}

/// The largest distance between a tile's surface and the samples of all tiles below it: brute force.
double measuredError(const PyramidReader& reader, const TileId& id, const raster::Raster<float>& surface,
                     const TileId& below) {
  const raster::SourceTile tile = loaded(reader, below);
  double largest = 0.0;
  const double scale = std::exp2(-(below.level - id.level));
  for (int r = 0; r <= kCells; ++r) {
    for (int c = 0; c <= kCells; ++c) {
      const double finest = static_cast<double>(heightsOf(tile).at(kGutter + c, kGutter + r));
      const double s = (below.x + static_cast<double>(c) / kCells) * scale - id.x;
      const double t = (below.y + static_cast<double>(r) / kCells) * scale - id.y;
      const double distance = std::abs(finest - surfaceAt(surface, s, t));
      if (distance > largest) largest = distance;
    }
  }
  for (int q = 0; q < 4; ++q) {
    if ((tile.childMask & (1 << q)) != 0)
      largest = std::max(largest, measuredError(reader, id, surface, below.child(q)));
  }
  return largest;
}

}  // namespace

void expectEdgesShared(const PyramidReader& reader) {
  const tiling::Tiling tiling(reader.info().scheme);
  int edges = 0;
  for (const TileId& id : storedTiles(reader)) {
    const raster::SourceTile tile = loaded(reader, id);
    for (const Edge edge : tiling::kEdges) {
      const tiling::EdgeNeighbour beyond = tiling.edgeNeighbour(id, edge);
      const auto neighbour = reader.load(beyond.tile);
      ASSERT_TRUE(neighbour.has_value());
      if (!*neighbour) continue;
      ++edges;
      for (int i = 0; i <= kCells; ++i) {
        const int along = beyond.reversed ? kCells - i : i;
        const auto mine = [&](int depth) { return sampleAtEdge(heightsOf(tile), edge, i, depth); };
        const auto theirs = [&](int depth) { return sampleAtEdge(heightsOf(**neighbour), beyond.edge, along, depth); };
        ASSERT_TRUE(sameBits(mine(0), theirs(0)))
            << "level " << int{id.level} << " root " << int{id.root} << " x " << id.x << " y " << id.y << " edge "
            << static_cast<int>(edge) << " sample " << i << ": " << mine(0) << " and " << theirs(0);
        ASSERT_TRUE(sameBits(mine(-1), theirs(1)))
            << "gutter, level " << int{id.level} << " root " << int{id.root} << " x " << id.x << " y " << id.y
            << " edge " << static_cast<int>(edge) << " sample " << i << ": " << mine(-1) << " and " << theirs(1);
      }
    }
  }
  EXPECT_GT(edges, 0);
}

void expectDecimated(const PyramidReader& reader) {
  for (const TileId& id : storedTiles(reader)) {
    const raster::SourceTile tile = loaded(reader, id);
    for (int q = 0; q < 4; ++q) {
      if ((tile.childMask & (1 << q)) == 0) continue;
      const raster::SourceTile child = loaded(reader, id.child(q));
      for (int r = 0; r <= kCells / 2; ++r) {
        for (int c = 0; c <= kCells / 2; ++c) {
          const float mine =
              heightsOf(tile).at(kGutter + c + (q & 1) * kCells / 2, kGutter + r + (q >> 1) * kCells / 2);
          ASSERT_TRUE(sameBits(mine, heightsOf(child).at(kGutter + 2 * c, kGutter + 2 * r)));
        }
      }
    }
  }
}

void expectErrorsBound(const PyramidReader& reader) {
  double worstRatio = 0.0;
  for (const TileId& id : storedTiles(reader)) {
    const raster::SourceTile tile = loaded(reader, id);
    const double measured = measuredError(reader, id, heightsOf(tile), id);
    ASSERT_LE(measured, static_cast<double>(tile.statistics.error_m) + 1e-6) << "level " << int{id.level};
    if (measured > 1.0) worstRatio = std::max(worstRatio, static_cast<double>(tile.statistics.error_m) / measured);
    for (int q = 0; q < 4; ++q) {
      if ((tile.childMask & (1 << q)) == 0) continue;
      const raster::SourceTile child = loaded(reader, id.child(q));
      EXPECT_GE(tile.statistics.error_m, child.statistics.error_m);
      EXPECT_LE(tile.statistics.min_m, child.statistics.min_m);
      EXPECT_GE(tile.statistics.max_m, child.statistics.max_m);
    }
  }
  std::printf("stated over measured error: %.3f at worst, %d levels\n", worstRatio, reader.info().maxLevel + 1);
}

}  // namespace tellurion::pyramid::testing
