// The boxes that the ground of a coarse tile is culled by (TileFacts::parts).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "geo/body.h"
#include "geo/seed_test.h"
#include "scene/procedural_source_test.h"
#include "scene/tile_content.h"
#include "scene/view_frustum.h"

namespace tellurion::scene {
namespace {

using tiling::Scheme;
using tiling::TileId;

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;
constexpr int kFinest = 5;

class TileParts : public testing::TestWithParam<Scheme> {
 protected:
  TileParts() {
    auto hills = std::make_shared<ProceduralSource>(raster::Kind::elevation, GetParam(), kFinest);
    auto tiles = std::make_shared<LayerTiles>(hills, std::uint64_t{1} << 30, std::make_shared<LoadLedger>());
    maker_.emplace(ContentMaker{.tiling = tiling_,
                                .ellipsoid = kEarth,
                                .ground = GroundLayers(tiling_, {tiles}, 64),
                                .colours = ColourLayers({})});
  }

  std::shared_ptr<const TileContent> madeOf(const TileId& id) const {
    const auto parent = id.level > 0 ? madeOf(id.parent()) : nullptr;
    return maker_->make(id, parent.get());
  }

  TileId somewhere(std::mt19937_64& random, int level) const {
    const auto index = [&] { return static_cast<std::uint32_t>(geo::uniform(random, 0.0, std::exp2(level) - 0.001)); };
    const auto root = static_cast<std::uint8_t>(geo::uniform(random, 0.0, tiling_.rootCount() - 0.001));
    return {static_cast<std::uint8_t>(level), root, index(), index()};
  }

  /// An eye that has the middle of the tile around or beyond its horizon.
  static geo::BodyPosition eyeBehind(const geo::Direction& middle, std::mt19937_64& random) {
    const double height_m = 1e4 * std::pow(3e3, geo::uniform(random, 0.0, 1.0));
    const double toHorizon = std::acos(kEarth.semiMinorAxis_m() / (kEarth.semiMinorAxis_m() + height_m));
    const double angle = toHorizon + geo::uniform(random, 0.0, 0.9);
    const geo::Vec3 any(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
    const geo::Vec3 aside = geo::normalize(geo::cross(middle.n, any));
    return kEarth.bodyFromDirection({middle.n * std::cos(angle) + aside * std::sin(angle)}, height_m);
  }

  tiling::Tiling tiling_{GetParam()};
  std::optional<ContentMaker> maker_;
};

INSTANTIATE_TEST_SUITE_P(All, TileParts, testing::Values(Scheme::geographic, Scheme::cube, Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// All that may be drawn of a tile, wholly its own or on its parent's surface, and the ground of all below it.
std::vector<geo::BodyPosition> pointsOf(const tiling::Tiling& tiling, const TileId& id, const TileContent& content,
                                        std::mt19937_64& random) {
  const auto vec = [](const auto& v) { return geo::Vec3(v[0], v[1], v[2]); };
  std::vector<geo::BodyPosition> points;
  for (const TerrainVertex& v : content.mesh->vertices) {
    const geo::BodyPosition own{content.mesh->origin.m + geo::Vec3(v.position_tile)};
    points.push_back(own);
    points.push_back(own + vec(v.toParent) * static_cast<double>(content.mesh->parentStep_m));
  }
  for (int i = 0; i < 200; ++i) {
    const geo::Direction d =
        tiling.direction(tiling::rootPointIn(id, geo::uniform(random, 0.0, 1.0), geo::uniform(random, 0.0, 1.0)));
    points.push_back(kEarth.bodyFromDirection(d, hillsAt(d)));
  }
  return points;
}

TEST_P(TileParts, hideNothingThatIsSeenAndMoreThanOneBox) {
  std::mt19937_64 random = geo::seededGenerator();
  int hidden = 0;
  int hiddenByOneBox = 0;
  for (int i = 0; i < 16; ++i) {
    const TileId id = somewhere(random, i % 4);
    const auto content = madeOf(id);
    ASSERT_FALSE(content->parts.empty());
    const auto points = pointsOf(tiling_, id, *content, random);
    const geo::Direction middle = tiling_.direction(tiling::rootPointIn(id, 0.5, 0.5));
    for (int k = 0; k < 300; ++k) {
      const geo::Horizon horizon = kEarth.horizon(eyeBehind(middle, random), geo::uniform(random, 0.0, 4000.0));
      hiddenByOneBox += isBeyondHorizon(content->box, horizon) ? 1 : 0;
      if (!std::ranges::all_of(content->parts, [&](const auto& part) { return isBeyondHorizon(part, horizon); }))
        continue;
      ++hidden;
      for (const geo::BodyPosition& p : points)
        ASSERT_TRUE(horizon.hides(p)) << int(id.level) << "/" << int(id.root) << "/" << id.x << "/" << id.y;
    }
  }
  std::printf("%d hidden, %d by one box\n", hidden, hiddenByOneBox);
  EXPECT_GT(hidden, 1.15 * hiddenByOneBox);
}

TEST_P(TileParts, areOnlyOfTilesThatBend) {
  std::mt19937_64 random = geo::seededGenerator();
  EXPECT_FALSE(madeOf(somewhere(random, 3))->parts.empty());
  EXPECT_TRUE(madeOf(somewhere(random, 4))->parts.empty());
}

}  // namespace
}  // namespace tellurion::scene
