#pragma once

// Places that the tests of all three tilings visit.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "geo/seed_test.h"
#include "tiling/tiling.h"

namespace tellurion::tiling {

inline constexpr std::array kSchemes{Scheme::geographic, Scheme::cube, Scheme::healpix};

inline geo::Direction randomDirection(std::mt19937_64& random) {
  const double z = geo::uniform(random, -1.0, 1.0);
  const double lon = geo::uniform(random, -geo::kPi, geo::kPi);
  const double r = std::sqrt((1.0 - z) * (1.0 + z));
  return {geo::Vec3(r * std::cos(lon), r * std::sin(lon), z)};
}

inline std::uint32_t randomBelow(std::mt19937_64& random, std::uint32_t count) {
  return static_cast<std::uint32_t>(random() % count);
}

inline TileId randomTile(std::mt19937_64& random, const Tiling& tiling, int level) {
  const std::uint32_t tiles = std::uint32_t{1} << level;
  const auto onBorderOften = [&](std::uint32_t n) {
    const std::uint32_t kind = randomBelow(random, 4);
    if (kind == 0) return 0u;
    return kind == 1 ? n - 1u : randomBelow(random, n);
  };
  return {static_cast<std::uint8_t>(level),
          static_cast<std::uint8_t>(randomBelow(random, static_cast<std::uint32_t>(tiling.rootCount()))),
          onBorderOften(tiles), onBorderOften(tiles)};
}

/// A multiple of 2^-40 in [0, 1]; often a coarse one.
inline double randomDyadic(std::mt19937_64& random) {
  const int bits = static_cast<int>(randomBelow(random, 41));
  return std::ldexp(static_cast<double>(random() % ((std::uint64_t{1} << bits) + 1)), -bits);
}

inline std::vector<TileId> allTiles(const Tiling& tiling, int level) {
  std::vector<TileId> tiles;
  const std::uint32_t side = std::uint32_t{1} << level;
  for (int root = 0; root < tiling.rootCount(); ++root) {
    for (std::uint32_t y = 0; y < side; ++y) {
      for (std::uint32_t x = 0; x < side; ++x) {
        tiles.push_back({static_cast<std::uint8_t>(level), static_cast<std::uint8_t>(root), x, y});
      }
    }
  }
  return tiles;
}

/// The place at `along` on an edge of a tile, in the edge's sense of running.
inline RootPoint onEdge(const TileId& id, Edge edge, double along) {
  switch (edge) {
    case Edge::top:
      return rootPointIn(id, along, 0.0);
    case Edge::right:
      return rootPointIn(id, 1.0, along);
    case Edge::bottom:
      return rootPointIn(id, along, 1.0);
    case Edge::left:
      break;
  }
  return rootPointIn(id, 0.0, along);
}

inline RootPoint atCorner(const TileId& id, Corner corner) {
  const bool right = corner == Corner::topRight || corner == Corner::bottomRight;
  const bool bottom = corner == Corner::bottomLeft || corner == Corner::bottomRight;
  return rootPointIn(id, right ? 1.0 : 0.0, bottom ? 1.0 : 0.0);
}

inline bool sameBits(const geo::Direction& a, const geo::Direction& b) {
  return std::bit_cast<std::array<std::uint64_t, 3>>(a.n) == std::bit_cast<std::array<std::uint64_t, 3>>(b.n);
}

inline bool isPole(const geo::Direction& d) {
  return d.n.x == 0.0 && d.n.y == 0.0;
}

/// The suite that runs once for each tiling, instantiated in tiling_test.cpp.
class EveryTiling : public ::testing::TestWithParam<Scheme> {
 protected:
  Tiling tiling_{GetParam()};
  std::mt19937_64 random_ = geo::seededGenerator();

  TileId anyTile() { return randomTile(random_, tiling_, static_cast<int>(randomBelow(random_, kMaxLevel + 1))); }
};

inline std::string toText(const TileId& id) {
  return std::to_string(id.level) + "/" + std::to_string(id.root) + "/" + std::to_string(id.x) + "/" +
         std::to_string(id.y);
}

}  // namespace tellurion::tiling
