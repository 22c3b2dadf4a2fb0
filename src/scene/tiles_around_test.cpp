#include "scene/tiles_around.h"

#include <gtest/gtest.h>

#include "geo/seed_test.h"

namespace tellurion::scene {
namespace {

using tiling::TileId;

class TilesAroundOn : public testing::TestWithParam<tiling::Scheme> {};
INSTANTIATE_TEST_SUITE_P(All, TilesAroundOn,
                         testing::Values(tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix),
                         [](const auto& scheme) { return std::string(tiling::nameOf(scheme.param)); });

/// What touches a child is where the table says: everywhere on the first levels, at random places further down.
TEST_P(TilesAroundOn, areSiblingsOrChildrenOfWhatTouchesTheParent) {
  const tiling::Tiling tiling(GetParam());
  std::mt19937_64 random = geo::seededGenerator();
  const auto expectKin = [&](const TileId& parent) {
    const TilesAround aroundParent = tilesAround(tiling, parent);
    for (int q = 0; q < 4; ++q) {
      const TilesAround around = tilesAround(tiling, parent.child(q));
      for (std::size_t place = 0; place < kAround; ++place) {
        const Kin kin = kinAround(q, place);
        if (kin.isSibling) {
          ASSERT_EQ(around[place], parent.child(kin.which));
        } else {
          const auto& over = aroundParent[kin.which];
          ASSERT_EQ(around[place].has_value(), over.has_value());
          if (over) {
            ASSERT_EQ(around[place]->parent(), *over);
          }
        }
      }
    }
  };
  for (std::uint8_t level = 0; level < 4; ++level) {
    for (int root = 0; root < tiling.rootCount(); ++root) {
      for (std::uint32_t i = 0; i < (1u << (2u * level)); ++i)
        expectKin({level, static_cast<std::uint8_t>(root), i >> level, i & ((1u << level) - 1u)});
    }
  }
  for (int i = 0; i < 2000; ++i) {
    const geo::Vec3 n(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
    expectKin(tiling.tileAt({geo::normalize(n)}, 4 + static_cast<int>(random() % 20)));
  }
}

/// What is told of a tile's root without the tiling is what the tiling tells.
TEST_P(TilesAroundOn, areKnownWithinTheRoot) {
  const tiling::Tiling tiling(GetParam());
  std::mt19937_64 random = geo::seededGenerator();
  int known = 0;
  const auto expectSame = [&](const TileId& id) {
    const TilesAround around = tilesAround(tiling, id);
    for (std::size_t place = 0; place < kAround; ++place) {
      const auto beside = besideInRoot(id, place);
      if (!beside) continue;
      ++known;
      ASSERT_EQ(around[place], beside);
    }
  };
  for (std::uint8_t level = 0; level < 5; ++level) {
    for (int root = 0; root < tiling.rootCount(); ++root) {
      for (std::uint32_t i = 0; i < (1u << (2u * level)); ++i)
        expectSame({level, static_cast<std::uint8_t>(root), i >> level, i & ((1u << level) - 1u)});
    }
  }
  for (int i = 0; i < 2000; ++i) {
    const geo::Vec3 n(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
    expectSame(tiling.tileAt({geo::normalize(n)}, static_cast<int>(random() % (tiling::kMaxLevel + 1))));
  }
  EXPECT_GT(known, 15000);
}

}  // namespace
}  // namespace tellurion::scene
