#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "tiling/places_test.h"

namespace tellurion::tiling {
namespace {

Edge horizontalEdge(Corner c) {
  return c == Corner::topLeft || c == Corner::topRight ? Edge::top : Edge::bottom;
}
Edge verticalEdge(Corner c) {
  return c == Corner::topLeft || c == Corner::bottomLeft ? Edge::left : Edge::right;
}

TEST_P(EveryTiling, NeighbourOfNeighbourComesBack) {
  for (int i = 0; i < 200000; ++i) {
    const TileId id = anyTile();
    for (const Edge edge : kEdges) {
      const EdgeNeighbour n = tiling_.edgeNeighbour(id, edge);
      ASSERT_EQ(n.tile.level, id.level);
      ASSERT_NE(n.tile, id);
      const EdgeNeighbour back = tiling_.edgeNeighbour(n.tile, n.edge);
      ASSERT_EQ(back.tile, id) << toText(id) << " edge " << static_cast<int>(edge);
      ASSERT_EQ(back.edge, edge);
      ASSERT_EQ(back.reversed, n.reversed);
    }
  }
}

TEST_P(EveryTiling, NeighboursShareTheirEdgeToTheLastBit) {
  for (int i = 0; i < 100000; ++i) {
    const TileId id = anyTile();
    for (const Edge edge : kEdges) {
      const EdgeNeighbour n = tiling_.edgeNeighbour(id, edge);
      const double along = randomBelow(random_, 65) / 64.0;
      const double theirs = n.reversed ? 1.0 - along : along;
      ASSERT_TRUE(
          sameBits(tiling_.direction(onEdge(id, edge, along)), tiling_.direction(onEdge(n.tile, n.edge, theirs))))
          << toText(id) << " edge " << static_cast<int>(edge);
    }
  }
}

TEST_P(EveryTiling, NeighboursLieOnTheOtherSideOfTheEdge) {
  for (int i = 0; i < 50000; ++i) {
    const TileId id = randomTile(random_, tiling_, 1 + static_cast<int>(randomBelow(random_, 20)));
    for (const Edge edge : kEdges) {
      const EdgeNeighbour n = tiling_.edgeNeighbour(id, edge);
      const geo::Vec3 shared = tiling_.direction(onEdge(id, edge, 0.5)).n;
      const geo::Vec3 inwards = tiling_.direction(rootPointIn(id, 0.5, 0.5)).n - shared;
      const geo::Vec3 outwards = tiling_.direction(rootPointIn(n.tile, 0.5, 0.5)).n - shared;
      ASSERT_LT(geo::dot(geo::normalize(inwards), geo::normalize(outwards)), 0.5) << toText(id);
    }
  }
}

// All tiles of a level that have a corner at a place, by brute force.
TEST_P(EveryTiling, CornerNeighboursAreAllThatTouchTheCorner) {
  for (int level = 0; level <= 4; ++level) {
    std::map<std::tuple<double, double, double>, std::set<TileId>> touching;
    const auto key = [this](const TileId& id, Corner c) {
      const geo::Vec3 n = tiling_.direction(atCorner(id, c)).n;
      return std::tuple(n.x, n.y, n.z);
    };
    const std::vector<TileId> tiles = allTiles(tiling_, level);
    for (const TileId& id : tiles) {
      for (const Corner c : kCorners)
        touching[key(id, c)].insert(id);
    }
    for (const TileId& id : tiles) {
      for (const Corner c : kCorners) {
        std::set<TileId> expected = touching[key(id, c)];
        expected.erase(id);
        expected.erase(tiling_.edgeNeighbour(id, horizontalEdge(c)).tile);
        expected.erase(tiling_.edgeNeighbour(id, verticalEdge(c)).tile);
        const std::optional<TileId> actual = tiling_.cornerNeighbour(id, c);
        ASSERT_EQ(actual ? std::set<TileId>{*actual} : std::set<TileId>{}, expected)
            << toText(id) << " " << static_cast<int>(c);
      }
    }
  }
}

TEST_P(EveryTiling, CornerNeighboursTouchTheCornerAndComeBackAtEveryLevel) {
  for (int i = 0; i < 50000; ++i) {
    const TileId id = anyTile();
    const Corner corner = kCorners[randomBelow(random_, 4)];
    const geo::Direction place = tiling_.direction(atCorner(id, corner));
    const std::optional<TileId> other = tiling_.cornerNeighbour(id, corner);
    if (!other) continue;
    bool comesBack = false;
    for (const Corner theirs : kCorners) {
      if (!sameBits(place, tiling_.direction(atCorner(*other, theirs)))) continue;
      comesBack = comesBack || tiling_.cornerNeighbour(*other, theirs) == id;
    }
    ASSERT_TRUE(comesBack) << toText(id) << " " << toText(*other);
  }
}

TEST_P(EveryTiling, WrappedLeavesTheInsideAlone) {
  for (const double u : {0.0, 0.25, 1.0}) {
    for (const double v : {0.0, 0.75, 1.0}) {
      const auto p = tiling_.wrapped({1, u, v});
      ASSERT_TRUE(p.has_value());
      EXPECT_EQ(p->root, 1);
      EXPECT_EQ(p->u, u);
      EXPECT_EQ(p->v, v);
    }
  }
}

// A grid of samples that runs on over an edge meets the neighbour's own samples, exactly.
TEST_P(EveryTiling, WrappedMeetsTheNeighboursSamples) {
  for (int i = 0; i < 100000; ++i) {
    const TileId id = randomTile(random_, tiling_, static_cast<int>(randomBelow(random_, 24)));
    const Edge edge = kEdges[randomBelow(random_, 4)];
    const double along = randomBelow(random_, 65) / 64.0;
    const double beyond = (1 + randomBelow(random_, 63)) / 64.0;
    const EdgeNeighbour n = tiling_.edgeNeighbour(id, edge);
    RootPoint p = onEdge(id, edge, along);
    (edge == Edge::top || edge == Edge::bottom ? p.v : p.u) +=
        (edge == Edge::top || edge == Edge::left ? -beyond : beyond) * tileSize(id.level);
    const auto wrapped = tiling_.wrapped(p);
    ASSERT_TRUE(wrapped.has_value());
    RootPoint expected = onEdge(n.tile, n.edge, n.reversed ? 1.0 - along : along);
    (n.edge == Edge::top || n.edge == Edge::bottom ? expected.v : expected.u) +=
        (n.edge == Edge::top || n.edge == Edge::left ? beyond : -beyond) * tileSize(id.level);
    ASSERT_EQ(wrapped->root, expected.root) << toText(id);
    ASSERT_EQ(wrapped->u, expected.u) << toText(id);
    ASSERT_EQ(wrapped->v, expected.v) << toText(id);
  }
}

TEST_P(EveryTiling, WrappedAcrossTwoEdgesIsWhereBothWaysMeetOrNothing) {
  for (int root = 0; root < tiling_.rootCount(); ++root) {
    for (const Corner c : kCorners) {
      const TileId id{0, static_cast<std::uint8_t>(root), 0, 0};
      const RootPoint corner = atCorner(id, c);
      const double du = corner.u == 0.0 ? -0.25 : 0.25;
      const double dv = corner.v == 0.0 ? -0.125 : 0.125;
      const auto wrapped = tiling_.wrapped({root, corner.u + du, corner.v + dv});
      const std::optional<TileId> other =
          tiling_.cornerNeighbour({3, id.root, corner.u == 0.0 ? 0u : 7u, corner.v == 0.0 ? 0u : 7u}, c);
      ASSERT_EQ(wrapped.has_value(), other.has_value()) << root << " " << static_cast<int>(c);
      ASSERT_TRUE(!wrapped || wrapped->root == other->root);
    }
  }
}

TEST(SixFaces, ThreeTilesMeetAtACornerAndFourAtThePole) {
  for (const Scheme scheme : {Scheme::geographic, Scheme::cube}) {
    const Tiling tiling(scheme);
    for (std::uint8_t root = 0; root < 6; ++root) {
      EXPECT_FALSE(tiling.cornerNeighbour({5, root, 31, 0}, Corner::topRight));
      EXPECT_FALSE(tiling.wrapped({root, 1.25, -0.25}).has_value());
    }
    EXPECT_EQ(tiling.cornerNeighbour({5, 4, 15, 15}, Corner::bottomRight), (TileId{5, 4, 16, 16}));
    EXPECT_TRUE(isPole(tiling.direction({4, 0.5, 0.5})));
    EXPECT_TRUE(isPole(tiling.direction({5, 0.5, 0.5})));
  }
}

TEST(GeographicTiling, AcrossTheParallelOf45DegreesTheMeridianGoesOn) {
  const Tiling tiling(Scheme::geographic);
  for (int root = 0; root < 4; ++root) {
    for (const double beyond : {-0.125, 1.125}) {
      const auto p = tiling.wrapped({root, 0.5, beyond});
      ASSERT_TRUE(p.has_value());
      EXPECT_EQ(p->root, beyond < 0.0 ? 4 : 5);
      const geo::Geodetic g = geo::geodeticFromDirection(tiling.direction(*p));
      EXPECT_NEAR(std::fabs(g.lat.degrees()), 90.0 - 0.75 * 45.0, 1e-12);
      EXPECT_NEAR(std::remainder(g.lon.degrees() - 90.0 * root, 360.0), 0.0, 1e-12);
    }
  }
}

TEST(HealpixTiling, FourTilesMeetAtThePoleAndThreeAtEightPlaces) {
  const Tiling tiling(Scheme::healpix);
  EXPECT_EQ(tiling.cornerNeighbour({5, 0, 0, 0}, Corner::topLeft), (TileId{5, 2, 0, 0}));
  EXPECT_EQ(tiling.cornerNeighbour({5, 9, 31, 31}, Corner::bottomRight), (TileId{5, 11, 31, 31}));
  int threes = 0;
  for (std::uint8_t root = 0; root < 12; ++root) {
    for (const Corner c : kCorners)
      threes += tiling.cornerNeighbour({0, root, 0, 0}, c) ? 0 : 1;
  }
  EXPECT_EQ(threes, 8 * 3);
}

}  // namespace
}  // namespace tellurion::tiling
