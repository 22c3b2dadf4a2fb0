#include "tiling/tiling.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <unordered_set>

#include "tiling/places_test.h"

namespace tellurion::tiling {
namespace {

constexpr double kRoundTrip_rad = 2e-15;  // 13 nm on Earth; five hundred times better than asked for
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(Schemes, EveryTiling, ::testing::ValuesIn(kSchemes),
                         [](const auto& scheme) { return std::string(nameOf(scheme.param)); });

double roundTripError(const Tiling& tiling, const geo::Direction& d) {
  const RootPoint p = tiling.rootPoint(d);
  EXPECT_TRUE(p.u >= 0.0 && p.u <= 1.0 && p.v >= 0.0 && p.v <= 1.0) << p.root << " " << p.u << " " << p.v;
  EXPECT_TRUE(p.root >= 0 && p.root < tiling.rootCount());
  return geo::angleBetween(d, tiling.direction(p)).radians();
}

TEST_P(EveryTiling, DirectionsComeBack) {
  double worst = 0.0;
  for (int i = 0; i < 300000; ++i)
    worst = std::max(worst, roundTripError(tiling_, randomDirection(random_)));
  std::printf("%s: round trip %.3g rad\n", std::string(nameOf(GetParam())).c_str(), worst);
  EXPECT_LT(worst, kRoundTrip_rad);
}

TEST_P(EveryTiling, DirectionsComeBackAtAndNextToPolesAndDateLine) {
  for (int i = 0; i < 100000; ++i) {
    const double tiny = std::exp(geo::uniform(random_, -50.0, 0.0));
    const double lon = geo::uniform(random_, -180.0, 180.0);
    for (const double side : {-1.0, 1.0}) {
      ASSERT_LT(roundTripError(tiling_, geo::directionFromDegrees(side * (90.0 - tiny), lon)), kRoundTrip_rad);
      ASSERT_LT(roundTripError(tiling_, geo::directionFromDegrees(lon / 2.0, side * (180.0 - tiny))), kRoundTrip_rad);
      ASSERT_LT(roundTripError(tiling_, geo::directionFromDegrees(lon / 2.0, side * tiny)), kRoundTrip_rad);
      ASSERT_LT(roundTripError(tiling_, geo::directionFromDegrees(side * tiny, lon)), kRoundTrip_rad);
    }
  }
  for (const double lat : {-90.0, -45.0, 0.0, 45.0, 90.0}) {
    for (double lon = -180.0; lon <= 180.0; lon += 45.0) {
      ASSERT_LT(roundTripError(tiling_, geo::directionFromDegrees(lat, lon)), kRoundTrip_rad) << lat << " " << lon;
    }
  }
}

TEST_P(EveryTiling, RootPointsComeBack) {
  for (int i = 0; i < 300000; ++i) {
    const int root = static_cast<int>(randomBelow(random_, static_cast<std::uint32_t>(tiling_.rootCount())));
    const bool exact = i % 2 == 0;
    const RootPoint p{root, exact ? randomDyadic(random_) : geo::uniform(random_, 0.0, 1.0),
                      exact ? randomDyadic(random_) : geo::uniform(random_, 0.0, 1.0)};
    ASSERT_LT(roundTripError(tiling_, tiling_.direction(p)), kRoundTrip_rad) << root << " " << p.u << " " << p.v;
  }
}

TEST_P(EveryTiling, DirectionsAreUnitVectorsWithoutNegativeZeros) {
  for (int i = 0; i < 100000; ++i) {
    const int root = static_cast<int>(randomBelow(random_, static_cast<std::uint32_t>(tiling_.rootCount())));
    const geo::Vec3 n = tiling_.direction({root, randomDyadic(random_), randomDyadic(random_)}).n;
    ASSERT_NEAR(geo::length(n), 1.0, 5e-16);
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_FALSE(n[axis] == 0.0 && std::signbit(n[axis]));
  }
}

TEST_P(EveryTiling, SharedEdgesAreTheSameToTheLastBitFromBothRoots) {
  for (int i = 0; i < 200000; ++i) {
    const auto root = static_cast<std::uint8_t>(i % tiling_.rootCount());
    const Edge edge = kEdges[randomBelow(random_, 4)];
    const double along = randomDyadic(random_);
    const EdgeNeighbour n = tiling_.edgeNeighbour({0, root, 0, 0}, edge);
    const geo::Direction here = tiling_.direction(onEdge({0, root, 0, 0}, edge, along));
    const geo::Direction there = tiling_.direction(onEdge(n.tile, n.edge, n.reversed ? 1.0 - along : along));
    ASSERT_TRUE(sameBits(here, there)) << int{root} << " edge " << static_cast<int>(edge) << " along " << along;
  }
}

TEST_P(EveryTiling, BorderBelongsToTheLowestRoot) {
  for (int i = 0; i < 200000; ++i) {
    const auto root = static_cast<std::uint8_t>(i % tiling_.rootCount());
    const Edge edge = kEdges[randomBelow(random_, 4)];
    const EdgeNeighbour n = tiling_.edgeNeighbour({0, root, 0, 0}, edge);
    const double along = std::clamp(randomDyadic(random_), 0x1p-20, 1.0 - 0x1p-20);
    const geo::Direction d = tiling_.direction(onEdge({0, root, 0, 0}, edge, along));
    ASSERT_EQ(tiling_.rootPoint(d).root, std::min<int>(root, n.tile.root)) << int{root} << " " << along;
  }
}

TEST_P(EveryTiling, EveryTileHoldsItsInside) {
  for (int i = 0; i < 200000; ++i) {
    const TileId id = randomTile(random_, tiling_, static_cast<int>(randomBelow(random_, kMaxLevel + 1)));
    const geo::Direction d =
        tiling_.direction(rootPointIn(id, geo::uniform(random_, 0.01, 0.99), geo::uniform(random_, 0.01, 0.99)));
    ASSERT_EQ(tiling_.tileAt(d, id.level), id) << toText(id);
  }
}

TEST_P(EveryTiling, UGoesRightAndVGoesDownSeenFromOutside) {
  for (int i = 0; i < 10000; ++i) {
    const int root = static_cast<int>(randomBelow(random_, static_cast<std::uint32_t>(tiling_.rootCount())));
    const RootPoint p{root, geo::uniform(random_, 0.01, 0.98), geo::uniform(random_, 0.01, 0.98)};
    const geo::Vec3 n = tiling_.direction(p).n;
    const geo::Vec3 alongU = tiling_.direction({root, p.u + 1e-3, p.v}).n - n;
    const geo::Vec3 alongV = tiling_.direction({root, p.u, p.v + 1e-3}).n - n;
    ASSERT_LT(geo::dot(geo::cross(alongU, alongV), n), 0.0);
  }
}

TEST_P(EveryTiling, NanIsNoPlace) {
  for (int axis = 0; axis < 3; ++axis) {
    geo::Direction d{geo::Vec3(0.1, 0.2, 0.3)};
    d.n[axis] = kNaN;
    const RootPoint p = tiling_.rootPoint(d);
    EXPECT_TRUE(std::isnan(p.u) || std::isnan(p.v)) << axis;
    EXPECT_LT(tiling_.tileAt(d, kMaxLevel).root, tiling_.rootCount());
  }
  EXPECT_TRUE(std::isnan(tiling_.direction({0, kNaN, 0.5}).n.x));
}

TEST_P(EveryTiling, AreasSumToTheSphere) {
  for (int level = 0; level <= 6; ++level) {
    double sum = 0.0;
    for (const TileId& id : allTiles(tiling_, level))
      sum += tiling_.area(id);
    EXPECT_NEAR(sum, 4.0 * geo::kPi, 1e-11) << level;
  }
}

TEST_P(EveryTiling, AreaIsTheChildrensDownToTheDeepestLevel) {
  for (int i = 0; i < 20000; ++i) {
    const TileId id = randomTile(random_, tiling_, static_cast<int>(randomBelow(random_, kMaxLevel)));
    double children = 0.0;
    for (int q = 0; q < 4; ++q)
      children += tiling_.area(id.child(q));
    ASSERT_NEAR(children / tiling_.area(id), 1.0, 1e-12) << toText(id);
  }
}

TEST_P(EveryTiling, AreaIsWhatADenseGridCovers) {
  for (int i = 0; i < 200; ++i) {
    const TileId id = randomTile(random_, tiling_, 2);
    constexpr int kSteps = 64;
    double sum = 0.0;
    for (int r = 0; r < kSteps; ++r) {
      for (int c = 0; c < kSteps; ++c) {
        const auto at = [&](int dc, int dr) {
          return tiling_.direction(rootPointIn(id, (c + dc) / double{kSteps}, (r + dr) / double{kSteps})).n;
        };
        sum += 0.5 * geo::length(geo::cross(at(1, 1) - at(0, 0), at(0, 1) - at(1, 0)));
      }
    }
    ASSERT_NEAR(sum / tiling_.area(id), 1.0, 3e-3) << toText(id);
  }
}

double edgeLength(const Tiling& tiling, const TileId& id, Edge edge) {
  constexpr int kPieces = 16;
  double sum = 0.0;
  for (int i = 0; i < kPieces; ++i) {
    sum += geo::angleBetween(tiling.direction(onEdge(id, edge, i / double{kPieces})),
                             tiling.direction(onEdge(id, edge, (i + 1) / double{kPieces})))
               .radians();
  }
  return sum;
}

TEST_P(EveryTiling, MetricsHoldEveryEdge) {
  for (int i = 0; i < 50000; ++i) {
    const int level = static_cast<int>(randomBelow(random_, kMaxLevel + 1));
    const TileId id = randomTile(random_, tiling_, level);
    const LevelMetrics m = tiling_.metrics(level);
    const double size = tileSize(level);
    const double chordsFallShort = 1.0 - 0.002 * size * size;  // (pi / 16)^2 / 24, of sixteen chords for an arc
    for (const Edge edge : kEdges) {
      const double length = edgeLength(tiling_, id, edge);
      ASSERT_LE(length, m.largestEdge.radians() + 1e-14) << toText(id);
      ASSERT_GE(length, m.smallestEdge.radians() * chordsFallShort - 1e-14) << toText(id);
    }
    ASSERT_LE(m.smallestEdge, m.meanEdge);
    ASSERT_LE(m.meanEdge, m.largestEdge);
  }
}

TEST_P(EveryTiling, MetricsAreReached) {
  constexpr int kLevel = 6;
  const LevelMetrics m = tiling_.metrics(kLevel);
  double shortest = 10.0;
  double longest = 0.0;
  double area = 0.0;
  const std::vector<TileId> tiles = allTiles(tiling_, kLevel);
  for (const TileId& id : tiles) {
    area += tiling_.area(id);
    for (const Edge edge : kEdges) {
      const double length = edgeLength(tiling_, id, edge);
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
    }
  }
  EXPECT_LT(shortest, 1.05 * m.smallestEdge.radians());
  EXPECT_GT(longest, 0.95 * m.largestEdge.radians());
  EXPECT_NEAR(m.meanEdge.radians(), std::sqrt(area / static_cast<double>(tiles.size())), 1e-12);
}

TEST_P(EveryTiling, NoSpacingInsideATileIsLargerThanTheMetricsSay) {
  for (int i = 0; i < 100000; ++i) {
    const int level = static_cast<int>(randomBelow(random_, 20));
    const TileId id = randomTile(random_, tiling_, level);
    const double s = geo::uniform(random_, 0.0, 63.0 / 64.0);
    const double t = geo::uniform(random_, 0.0, 63.0 / 64.0);
    const geo::Direction d = tiling_.direction(rootPointIn(id, s, t));
    const double most = tiling_.metrics(level).largestEdge.radians() / 64.0 + 1e-15;
    ASSERT_LE(geo::angleBetween(d, tiling_.direction(rootPointIn(id, s + 1.0 / 64.0, t))).radians(), most);
    ASSERT_LE(geo::angleBetween(d, tiling_.direction(rootPointIn(id, s, t + 1.0 / 64.0))).radians(), most);
  }
}

// What decision 10 says of the caps: no tile smaller than 0.386 of the largest, which lie at the poles and on the
// equator.
TEST(GeographicTiling, AreasOfALevel) {
  const Tiling tiling(Scheme::geographic);
  constexpr std::uint8_t kLevel = 8;
  constexpr std::uint32_t kMiddle = 128;
  double smallest = 10.0;
  double largest = 0.0;
  for (const TileId& id : allTiles(tiling, kLevel)) {
    smallest = std::min(smallest, tiling.area(id));
    largest = std::max(largest, tiling.area(id));
  }
  EXPECT_NEAR(tiling.area({kLevel, 4, kMiddle, kMiddle}) / largest, 1.0, 1e-4);
  EXPECT_NEAR(tiling.area({kLevel, 0, 0, kMiddle}) / largest, 1.0, 1e-4);
  EXPECT_EQ(tiling.area({kLevel, 4, 0, 0}), smallest);
  EXPECT_NEAR(smallest / largest, 0.389, 0.003);
}

TEST(HealpixTiling, TilesOfALevelAreOfEqualArea) {
  const Tiling tiling(Scheme::healpix);
  for (const TileId& id : allTiles(tiling, 5))
    ASSERT_EQ(tiling.area(id), geo::kPi / 3.0 / 1024.0);
}

TEST(TileId, ParentsAndChildren) {
  const TileId id{3, 7, 5, 2};
  for (int q = 0; q < 4; ++q) {
    const TileId child = id.child(q);
    EXPECT_EQ(child.parent(), id);
    EXPECT_EQ(child.quadrant(), q);
    EXPECT_TRUE(child.isDescendantOf(id));
    EXPECT_FALSE(id.isDescendantOf(child));
  }
  EXPECT_EQ(id.child(1), (TileId{4, 7, 11, 4}));
  EXPECT_EQ(id.child(2), (TileId{4, 7, 10, 5}));
  EXPECT_EQ(id.ancestor(1), (TileId{1, 7, 1, 0}));
  EXPECT_EQ(id.ancestor(3), id);
  EXPECT_TRUE(id.isDescendantOf(id));
  EXPECT_FALSE(id.isDescendantOf({0, 6, 0, 0}));
  EXPECT_LT((TileId{1, 5, 1, 1}), (TileId{2, 0, 0, 0}));
}

TEST(TileId, HashesOfAWholeLevelDiffer) {
  std::unordered_set<std::size_t> hashes;
  const std::vector<TileId> tiles = allTiles(Tiling(Scheme::healpix), 5);
  for (const TileId& id : tiles)
    hashes.insert(TileIdHash{}(id));
  EXPECT_EQ(hashes.size(), tiles.size());
}

TEST(Scheme, Names) {
  for (const Scheme scheme : kSchemes)
    EXPECT_EQ(schemeByName(nameOf(scheme)), scheme);
  EXPECT_FALSE(schemeByName("Cube").has_value());
  EXPECT_FALSE(schemeByName("").has_value());
}

}  // namespace
}  // namespace tellurion::tiling
