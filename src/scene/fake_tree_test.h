#pragma once

// A forest of tiles without content, and views of it: what chooses the tiles needs no more.

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <unordered_map>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/select.h"
#include "scene/tile_content.h"

namespace tellurion::scene {

using tiling::Scheme;
using tiling::TileId;
using tiling::Tiling;

inline const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

/// A forest out of a rule: error a share of a tile's size, everything loaded unless said otherwise.
class FakeTree final : public TileTree {
 public:
  explicit FakeTree(const Tiling& tiling) : tiling_(tiling) {}

  std::function<bool(const TileId&)> loaded = [](const TileId&) { return true; };
  std::function<double(const TileId&)> roughness = [](const TileId&) { return 1.0; };
  std::function<std::uint64_t(const TileId&)> copies = [](const TileId&) { return 0; };
  int deepest = 16;
  double texelsAcross = std::numeric_limits<double>::infinity();
  HeightRange range{.low_m = -500.0, .high_m = 9000.0};

  static constexpr std::int64_t kTriangles = 100;  ///< of a tile
  static constexpr std::uint64_t kBytesATriangle = 50;

  TileFacts* root(int root) override { return facts({.level = 0, .root = static_cast<std::uint8_t>(root)}); }
  std::array<TileFacts*, 4> children(const TileId& id, TileFacts&) override {
    return {facts(id.child(0)), facts(id.child(1)), facts(id.child(2)), facts(id.child(3))};
  }

  TileFacts* facts(const TileId& id) {
    const auto [found, isNew] = facts_.try_emplace(id);
    if (isNew) {
      found->second.drawable = loaded(id);
      found->second.copy_bytes = copies(id);
      found->second.box = estimatedBox(tiling_, kEarth, id, range);
      found->second.tightBox = found->second.box;
      found->second.corners = tileCorners(tiling_, id);
      found->second.around = tilesAround(tiling_, id);
      found->second.triangles = kTriangles;
      found->second.bytes = static_cast<std::uint64_t>(kTriangles) * kBytesATriangle;
      const double size_m = tiling_.metrics(id.level).meanEdge.radians() * kEarth.semiMajorAxis_m();
      found->second.spacing_m = id.level < deepest ? size_m / 64.0 : 0.0;
      found->second.texel_m = id.level < deepest ? size_m / texelsAcross : 0.0;
      found->second.error_m = id.level < deepest ? 0.003 * size_m * roughness(id) : 0.0;
    }
    return &found->second;
  }

 private:
  Tiling tiling_;
  std::unordered_map<TileId, TileFacts, tiling::TileIdHash> facts_;
};

inline View viewOver(double lat, double lon, double height_m, double heading, double pitch) {
  const Camera camera{
      .position = {.lat = geo::Angle::degrees(lat), .lon = geo::Angle::degrees(lon), .height_m = height_m},
      .heading = geo::Angle::degrees(heading),
      .pitch = geo::Angle::degrees(pitch),
      .roll = {}};
  return viewOf(camera, kEarth, geo::Angle::degrees(50.0), {.width = 1000, .height = 700});
}

inline View randomView(std::mt19937_64& random) {
  return viewOver(std::asin(geo::uniform(random, -1, 1)) * 180 / geo::kPi, geo::uniform(random, -180, 180),
                  9500.0 + std::exp(geo::uniform(random, 0, 17)), geo::uniform(random, 0, 360),
                  geo::uniform(random, -90, 20));
}

}  // namespace tellurion::scene
