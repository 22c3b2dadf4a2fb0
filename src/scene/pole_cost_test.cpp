// What a pole in view costs, beside the equator in the same view: tiles, triangles and texels (docs/tilings.md).
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <set>

#include "scene/globe.h"
#include "scene/procedural_source_test.h"

namespace tellurion::scene {
namespace {

using namespace std::chrono_literals;
using tiling::Scheme;

struct Place {
  double lat;
  double lon;
};

struct Cost {
  double tiles = 0.0;
  double triangles = 0.0;
  double texels = 0.0;
};

std::size_t indicesDrawn(const DrawnTile& tile) {
  std::size_t count = tile.mesh->interior.count;
  for (std::size_t e = 0; e < 4; ++e)
    count += (((tile.coarseEdges >> e) & 1u) != 0 ? tile.mesh->coarseEdge : tile.mesh->fineEdge)[e].count;
  return count;
}

Cost costOf(const Frame& frame) {
  Cost cost;
  std::set<std::uint64_t> seen;
  for (const DrawnTile& tile : frame.tiles) {
    cost.tiles += 1.0;
    cost.triangles += static_cast<double>(indicesDrawn(tile)) / 3.0;
    const auto add = [&](const TextureImage& picture) {
      if (seen.insert(picture.serial).second) cost.texels += static_cast<double>(picture.mips.front().samples.size());
    };
    if (tile.relief) add(*tile.relief);
    for (std::size_t i = tile.firstPicture; i < tile.firstPicture + tile.pictureCount; ++i)
      add(*frame.pictures[i].image);
  }
  return cost;
}

/// Alike everywhere and in all directions, on all scales down to metres: noise between the corners of cubes in space.
double noiseAt(const geo::Vec3& p, std::uint64_t seed) {
  const auto mixed = [](std::uint64_t h, double v) {
    h = (h ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(v))) * 0x9e3779b97f4a7c15u;
    return h ^ (h >> 29);
  };
  const auto smooth = [](double x) { return x * x * (3.0 - 2.0 * x); };
  const geo::Vec3 base(std::floor(p.x), std::floor(p.y), std::floor(p.z));
  const geo::Vec3 f(smooth(p.x - base.x), smooth(p.y - base.y), smooth(p.z - base.z));
  // An axis at a time: corners share what is mixed of the axes before.
  double sum = 0.0;
  for (const double x : {0.0, 1.0}) {
    const std::uint64_t ofX = mixed(seed, base.x + x);
    for (const double y : {0.0, 1.0}) {
      const std::uint64_t ofXY = mixed(ofX, base.y + y);
      const double weight = (x > 0.0 ? f.x : 1.0 - f.x) * (y > 0.0 ? f.y : 1.0 - f.y);
      for (const double z : {0.0, 1.0}) {
        const std::uint64_t h = mixed(ofXY, base.z + z) * 0xbf58476d1ce4e5b9u;
        sum += weight * (z > 0.0 ? f.z : 1.0 - f.z) * (static_cast<double>(h >> 11) * 0x1p-52 - 1.0);
      }
    }
  }
  return sum;
}

constexpr int kOctaves = 18;
/// Those that a level's samples are close enough for; of the others it lacks less than its tiles state as their error.
int octavesOf(int level) {
  return std::min(level + 4, kOctaves);
}
double reliefAt(const geo::Direction& d, int octaves) {
  // Turned, so that no axis of the noise is one of the body.
  const geo::Vec3 p(0.8 * d.n.x + 0.48 * d.n.y + 0.36 * d.n.z, -0.6 * d.n.x + 0.64 * d.n.y + 0.48 * d.n.z,
                    -0.6 * d.n.y + 0.8 * d.n.z);
  double height_m = 0.0;
  double size_m = 3000.0;
  double frequency = 4.0;
  for (int octave = 0; octave < octaves; ++octave, frequency *= 2.0, size_m *= 0.55)
    height_m += size_m * noiseAt(p * frequency, static_cast<std::uint64_t>(octave));
  return height_m;
}

constexpr int kDepth = 14;

/// The relief, of each level with its own octaves.
class Relief final : public raster::TileSource {
 public:
  explicit Relief(Scheme scheme) {
    for (int level = 0; level <= kDepth; ++level) {
      levels_.emplace_back(raster::Kind::elevation, scheme, kDepth);
      levels_.back().height = [octaves = octavesOf(level)](const geo::Direction& d) { return reliefAt(d, octaves); };
      levels_.back().heightBound_m = 8000.0;
      levels_.back().error_m = [](int of) { return 3000.0 * std::pow(0.55, of + 2.0); };
    }
    info_ = levels_.front().info();
    info_.isNested = false;
  }
  const raster::TileSourceInfo& info() const override { return info_; }
  io::Result<std::optional<raster::SourceTile>> load(const tiling::TileId& id) const override {
    return levels_.at(id.level).load(id);
  }

 private:
  std::deque<ProceduralSource> levels_;
  raster::TileSourceInfo info_;
};

std::unique_ptr<Globe> planetOf(Scheme scheme, bool withRelief) {
  Scene scene;
  scene.tiling = scheme;
  GlobeLayers layers;
  if (withRelief) {
    layers.elevation = {std::make_shared<Relief>(scheme)};
    layers.imagery = {{.source = std::make_shared<ProceduralSource>(raster::Kind::imagery, scheme, kDepth)}};
  }
  return Globe::fromLayers(scene, std::move(layers), {}).value();
}

struct Sight {
  double aboveGround_m;
  double pitch;
};

/// From 4 radii to 100 m, straight down and aslant. From far out what looks aslant sees the sky.
std::vector<Sight> sights(double octaves) {
  std::vector<Sight> all;
  for (double octave = 0.0; octave < 18.1; octave += octaves) {
    const double above_m = 4.0 * geo::earth().ellipsoid.semiMajorAxis_m() * std::exp2(-octave);
    all.push_back({above_m, -90.0});
    if (above_m < 4e6) all.push_back({above_m, -30.0});
  }
  return all;
}

Cost costOf(Globe& globe, const Place& place, const Sight& sight, bool withRelief) {
  const double ground_m = withRelief ? reliefAt(geo::directionFromDegrees(place.lat, place.lon), kOctaves) : 0.0;
  const Camera camera{.position = {.lat = geo::Angle::degrees(place.lat),
                                   .lon = geo::Angle::degrees(place.lon),
                                   .height_m = ground_m + sight.aboveGround_m},
                      .heading = geo::Angle::degrees(30.0),
                      .pitch = geo::Angle::degrees(sight.pitch),
                      .roll = {}};
  // Noise takes long to make, and there are tiles enough of it in a smaller picture.
  const Viewport size = withRelief ? Viewport{.width = 384, .height = 288} : Viewport{.width = 512, .height = 384};
  const View view = viewOf(camera, geo::earth().ellipsoid, geo::Angle::degrees(45.0), size);
  const auto end = std::chrono::steady_clock::now() + 240s;
  while (std::chrono::steady_clock::now() < end) {
    const Frame& frame = globe.update(view, {});
    if (frame.complete) return costOf(frame);
    globe.waitForArrivals(1000ms);
  }
  ADD_FAILURE() << "never complete";
  return {};
}

Cost largest(const Cost& a, const Cost& b) {
  return {std::max(a.tiles, b.tiles), std::max(a.triangles, b.triangles), std::max(a.texels, b.texels)};
}
Cost sum(const Cost& a, const Cost& b) {
  return {a.tiles + b.tiles, a.triangles + b.triangles, a.texels + b.texels};
}

/// How much more a pole may cost than the dearest of some places on the equator, whose tiles lie in the picture this
/// way and that.
struct Allowed {
  double tiles;  ///< and texels, which go with them
  double triangles;
};

struct Costs {
  Cost pole;
  Cost equator;
};

void expectNoMore(const Costs& costs, const Allowed& allowed, const std::string& where) {
  EXPECT_GT(costs.pole.tiles, 0.0) << where;
  EXPECT_LE(costs.pole.tiles, allowed.tiles * costs.equator.tiles) << where;
  EXPECT_LE(costs.pole.texels, allowed.tiles * costs.equator.texels) << where;
  EXPECT_LE(costs.pole.triangles, allowed.triangles * costs.equator.triangles) << where;
}

std::string told(const Sight& sight) {
  return std::to_string(sight.aboveGround_m) + " m, pitch " + std::to_string(sight.pitch);
}

class PoleCost : public testing::TestWithParam<Scheme> {
 protected:
  void open(bool withRelief) {
    withRelief_ = withRelief;
    globe_ = planetOf(GetParam(), withRelief);
  }
  /// The largest of the two poles and of the equator's places.
  Costs of(const Sight& sight) {
    Costs costs;
    for (std::size_t i = 0; i < kPlaces.size(); ++i) {
      Cost& among = i < 2 ? costs.pole : costs.equator;
      among = largest(among, costOf(*globe_, kPlaces[i], sight, withRelief_));
    }
    return costs;
  }

 private:
  static constexpr std::array kPlaces{Place{90, 0}, Place{-90, 20}, Place{0, 0},
                                      Place{0, 23}, Place{0, 70.3}, Place{0, 157}};
  std::unique_ptr<Globe> globe_;  ///< frames depend on their view alone
  bool withRelief_ = false;
};
INSTANTIATE_TEST_SUITE_P(All, PoleCost, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

constexpr Allowed kAllowed{1.25, 1.25};

TEST_P(PoleCost, isNoMoreThanTheEquatorsInTheSameViewOfReliefAndPictures) {
  if (GetParam() == Scheme::healpix) GTEST_SKIP() << "its pixels are longer at the poles: see below";
  open(true);
  Cost most;
  for (const Sight& sight : sights(4.25)) {
    const Costs costs = of(sight);
    most = largest(most, {costs.pole.tiles / costs.equator.tiles, costs.pole.triangles / costs.equator.triangles,
                          costs.pole.texels / costs.equator.texels});
    expectNoMore(costs, kAllowed, told(sight));
  }
  std::printf("poles cost at most %.2f times the tiles, %.2f the triangles, %.2f the texels\n", most.tiles,
              most.triangles, most.texels);
}

/// At its poles HEALPix's pixels, of equal area everywhere, are up to 1.86 times as long as wide. For texels that are
/// no longer than a pixel of the picture that takes (2/3) (1 + (pi/2)^2 7/12) over (pi/4)^2 + (2/3)^2, 1.53 times as
/// many tiles there as on the equator, on the average of all heights: at a single one a whole level may be split in the
/// one place only. Its lines are bent around the poles at every scale, so that a picture keeps its place only where
/// meshes have vertices that the ground does not ask for: some hundred in each tile at a pole, fewer the further off,
/// and so a bounded number, however near one comes.
TEST_P(PoleCost, onHealpixIsWhatTheShapeOfItsPixelsTakes) {
  if (GetParam() != Scheme::healpix) GTEST_SKIP();
  constexpr Allowed kByShape{1.6, 1.25};
  constexpr double kVerticesForPictures = 3000.0;  // triangles
  open(true);
  Costs total;
  double most = 0.0;
  for (const Sight& sight : sights(4.25)) {  // all parts of an octave alike
    const Costs costs = of(sight);
    total = {sum(total.pole, costs.pole), sum(total.equator, costs.equator)};
    most = std::max(most, costs.pole.triangles - kByShape.triangles * costs.equator.triangles);
    EXPECT_LE(costs.pole.tiles, 4.0 * costs.equator.tiles) << told(sight);
    EXPECT_LE(costs.pole.triangles, kByShape.triangles * costs.equator.triangles + kVerticesForPictures) << told(sight);
  }
  EXPECT_LE(total.pole.tiles, kByShape.tiles * total.equator.tiles);
  EXPECT_LE(total.pole.texels, kByShape.tiles * total.equator.texels);
  std::printf("poles cost %.2f times the tiles, %.2f the texels; %.0f triangles more than %.2f times the equator's\n",
              total.pole.tiles / total.equator.tiles, total.pole.texels / total.equator.texels, most,
              kByShape.triangles);
}

/// On the bare ellipsoid all tiles of a level are split at nearly one height, which is not the same here and there:
/// over the heights it must even out.
TEST_P(PoleCost, isNoMoreThanTheEquatorsOverTheBareEllipsoid) {
  if (GetParam() == Scheme::healpix) GTEST_SKIP() << "its lines bent around the poles are all that there is: see below";
  open(false);
  Costs total;
  for (const Sight& sight : sights(0.5)) {
    const Costs costs = of(sight);
    total = {sum(total.pole, costs.pole), sum(total.equator, costs.equator)};
    EXPECT_LE(costs.pole.triangles, 1.5 * costs.equator.triangles)
        << sight.aboveGround_m << " m, pitch " << sight.pitch;
  }
  std::printf("poles %.0f tiles, %.0f triangles, equator %.0f, %.0f\n", total.pole.tiles, total.pole.triangles,
              total.equator.tiles, total.equator.triangles);
  expectNoMore(total, {1.25, 1.1}, "all heights");
}

/// There is nothing but HEALPix's lines to refine, so a few tiles must not be compared with: it is bounded.
TEST_P(PoleCost, onHealpixIsBoundedOverTheBareEllipsoid) {
  if (GetParam() != Scheme::healpix) GTEST_SKIP();
  constexpr double kMoreTiles = 80.0;
  constexpr double kMoreTriangles = 3000.0;
  open(false);
  Cost most;
  for (const Sight& sight : sights(0.5)) {
    const Costs costs = of(sight);
    EXPECT_LE(costs.pole.tiles, 1.25 * costs.equator.tiles + kMoreTiles) << told(sight);
    EXPECT_LE(costs.pole.triangles, 1.25 * costs.equator.triangles + kMoreTriangles) << told(sight);
    most = largest(most, {.tiles = costs.pole.tiles - costs.equator.tiles,
                          .triangles = costs.pole.triangles - costs.equator.triangles});
  }
  std::printf("poles cost up to %.0f tiles and %.0f triangles more\n", most.tiles, most.triangles);
}

}  // namespace
}  // namespace tellurion::scene
