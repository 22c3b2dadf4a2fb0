// The ground between points against the points themselves, and against itself where its blocks meet.
#include "raster/point_ground.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "geo/seed_test.h"
#include "raster/raster.h"

namespace tellurion::raster {
namespace {

using geo::Direction;
using Generator = std::mt19937_64;
using Heights = std::function<double(const Direction&)>;

constexpr std::uint64_t kCache = std::uint64_t{8} << 20u;

/// Smooth, and steep enough that a wrong triangle shows.
double hills(const Direction& place) {
  return 900.0 * std::sin(90.0 * place.n.x + 2.0) * std::cos(110.0 * place.n.y) + 500.0 * std::sin(170.0 * place.n.z);
}

/// Places over a rectangle in degrees, evenly by area where it is small; in any turn.
std::vector<Direction> spread(Generator& random, int count, double lat, double lon, double height, double width) {
  std::vector<Direction> places;
  for (int i = 0; i < count; ++i) {
    places.push_back(geo::directionFromDegrees(lat + height * geo::uniform(random, 0.0, 1.0),
                                               lon + width * geo::uniform(random, 0.0, 1.0)));
  }
  return places;
}

/// Within a circle around a pole, in radians.
std::vector<Direction> aroundPole(Generator& random, int count, double radius) {
  std::vector<Direction> places;
  for (int i = 0; i < count; ++i) {
    const double r = radius * std::sqrt(geo::uniform(random, 0.0, 1.0));
    const double turn = geo::uniform(random, 0.0, 6.2831853);
    places.push_back({geo::Vec3(std::sin(r) * std::cos(turn), std::sin(r) * std::sin(turn), std::cos(r))});
  }
  return places;
}

std::vector<Direction> gridded(double lat, double lon, double step, int rows, int columns) {
  std::vector<Direction> places;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      places.push_back(geo::directionFromDegrees(lat + step * row, lon + step * column));
  }
  return places;
}

std::vector<PackedPoint> packed(const std::vector<Direction>& places, const Heights& height) {
  std::vector<PackedPoint> points;
  for (const Direction& place : places)
    points.push_back(packedPoint(place, static_cast<float>(height(place))));
  return points;
}

PointGround groundOf(const std::vector<Direction>& places, const Heights& height = hills) {
  return PointGround(ScatteredPoints(packed(places, height)), kCache);
}

/// All levels, as a build lays them.
std::vector<float> heightsAt(const PointGround& ground, const std::vector<Direction>& places) {
  std::vector<float> heights(places.size(), kNoData);
  for (const int level : ground.points().spacingLevels())
    EXPECT_TRUE(ground.sampleHeights(level, places, heights).has_value());
  return heights;
}

/// Sets of points that are hard in one way each.
struct Case {
  const char* name;
  std::vector<Direction> places;
};
std::vector<Case> cases(Generator& random) {
  std::vector<Case> all;
  all.push_back({"random over the date line", spread(random, 4000, -18.0, 179.0, 2.0, 2.0)});
  all.push_back({"random around a pole", aroundPole(random, 4000, 0.03)});
  all.push_back({"grid of longitude and latitude", gridded(46.0, 7.0, 0.02, 60, 60)});
  all.push_back({"coarse grid", gridded(-30.0, 30.0, 0.5, 60, 60)});
  std::vector<Direction> mixed = spread(random, 3000, 46.0, 7.0, 2.0, 2.0);
  std::ranges::copy(spread(random, 12000, 46.7, 7.7, 0.3, 0.3), std::back_inserter(mixed));
  all.push_back({"a dense survey in a sparse one", mixed});
  std::vector<Direction> tracks = spread(random, 1000, 10.0, 10.0, 2.0, 2.0);
  for (int track = 0; track < 8; ++track) {
    for (int i = 0; i < 1500; ++i)
      tracks.push_back(geo::directionFromDegrees(10.0 + 0.0013 * i, 10.0 + 0.24 * track + 0.0001 * i));
  }
  all.push_back({"tracks", tracks});
  return all;
}

TEST(PointGround, GoesThroughItsPoints) {
  auto random = geo::seededGenerator();
  for (const auto& places : {spread(random, 5000, -18.0, 179.0, 2.0, 2.0), aroundPole(random, 5000, 0.03),
                             gridded(46.0, 7.0, 0.02, 60, 60), spread(random, 5000, 46.0, 7.0, 0.002, 0.003)}) {
    const PointGround ground = groundOf(places);
    int found = 0;
    const auto heights = heightsAt(ground, places);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (isNoData(heights[i])) continue;  // rounding may put a corner of the border outside
      ++found;
      EXPECT_NEAR(heights[i], hills(places[i]), 0.01);
    }
    EXPECT_GT(found, static_cast<int>(places.size()) * 98 / 100);
  }
}

TEST(PointGround, OfAPlaneIsThePlane) {
  auto random = geo::seededGenerator();
  // Small enough for the body's curvature not to count.
  const geo::Vec3 slope(30000.0, -70000.0, 50000.0);
  const Direction origin = geo::directionFromDegrees(46.0, 7.0);
  const Heights plane = [&](const Direction& place) { return geo::dot(slope, place.n - origin.n); };
  const PointGround ground = groundOf(spread(random, 5000, 46.0, 7.0, 0.1, 0.1), plane);
  const auto asked = spread(random, 3000, 46.005, 7.005, 0.09, 0.09);
  const auto heights = heightsAt(ground, asked);
  for (std::size_t i = 0; i < asked.size(); ++i)
    EXPECT_NEAR(heights[i], plane(asked[i]), 1e-3);
}

TEST(PointGround, DoesNotDependOnTheOrderOfThePoints) {
  auto random = geo::seededGenerator();
  for (const Case& of : cases(random)) {
    std::vector<PackedPoint> points = packed(of.places, hills);
    const auto asked = spread(random, 2000, 46.0, 7.0, 2.0, 2.0);
    const auto before = heightsAt(PointGround(ScatteredPoints(points), kCache), asked);
    std::ranges::shuffle(points, random);
    const auto after = heightsAt(PointGround(ScatteredPoints(points), kCache), asked);
    for (std::size_t i = 0; i < asked.size(); ++i)
      EXPECT_TRUE(before[i] == after[i] || (isNoData(before[i]) && isNoData(after[i]))) << of.name;
  }
}

/// Pairs of places that lie on either side of a border between blocks, of any level, at random along it.
std::vector<Direction> acrossBorders(const PointGround& ground, Generator& random, const std::vector<Direction>& near) {
  constexpr double kStep = 1e-10;
  constexpr int kBlockLevels = 4;
  std::vector<Direction> places;
  for (const int level : ground.points().spacingLevels()) {
    for (int i = 0; i < 400; ++i) {
      const Direction& place = near[random() % near.size()];
      const tiling::TileId id = kPointIndex.tileAt(place, std::max(0, level - kBlockLevels));
      const double along = geo::uniform(random, 0.0, 1.0);
      for (const double across : {-kStep, kStep}) {
        tiling::RootPoint at = tiling::rootPointIn(id, 0.0, 0.0);
        const double size = tiling::tileSize(id.level);
        (i % 2 == 0 ? at.u : at.v) += across;
        (i % 2 == 0 ? at.v : at.u) += along * size;
        const auto inside = kPointIndex.wrapped(at);
        if (inside) places.push_back(kPointIndex.direction(*inside));
      }
    }
  }
  return places;
}

TEST(PointGround, HasNoStepWhereBlocksMeet) {
  auto random = geo::seededGenerator();
  for (const Case& of : cases(random)) {
    const PointGround ground = groundOf(of.places);
    const auto places = acrossBorders(ground, random, of.places);
    const auto all = heightsAt(ground, places);
    for (std::size_t i = 0; i + 1 < places.size(); i += 2)
      EXPECT_EQ(isNoData(all[i]), isNoData(all[i + 1])) << of.name;
    for (const int level : ground.points().spacingLevels()) {
      std::vector<float> heights(places.size(), kNoData);
      ASSERT_TRUE(ground.sampleHeights(level, places, heights).has_value());
      int differ = 0;
      // A border may run along a side between ground of two levels, as in a grid: there one of the two has none.
      for (std::size_t i = 0; i + 1 < places.size(); i += 2)
        differ += std::abs(heights[i] - heights[i + 1]) > 0.01F ? 1 : 0;
      EXPECT_EQ(differ, 0) << of.name << ", level " << level << ", of " << places.size() / 2;
    }
  }
}

TEST(PointGround, ReachesNoFartherFromAPointThanItSays) {
  auto random = geo::seededGenerator();
  for (const Case& of : cases(random)) {
    const PointGround ground = groundOf(of.places);
    const ScatteredPoints& points = ground.points();
    const double widest = ScatteredPoints::spacingOf(points.spacingLevels().front()).radians();
    std::vector<Direction> asked;
    for (int i = 0; i < 100; ++i) {
      const Direction& near = of.places[random() % of.places.size()];
      const geo::Vec3 aside(geo::uniform(random, -1.0, 1.0), geo::uniform(random, -1.0, 1.0),
                            geo::uniform(random, -1.0, 1.0));
      asked.push_back({geo::normalize(near.n + aside * (4.0 * widest))});
    }
    const auto heights = heightsAt(ground, asked);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      double nearest = 10.0;
      for (const Direction& place : of.places)
        nearest = std::min(nearest, geo::length(place.n - asked[i].n));
      if (!isNoData(heights[i])) {
        EXPECT_LE(nearest, PointGround::kWidestCircle * widest * 1.001) << of.name;
      }
    }
  }
}

TEST(PointGround, LeavesGapsAndSurroundingsWithoutData) {
  auto random = geo::seededGenerator();
  std::vector<Direction> places = spread(random, 20000, 46.0, 7.0, 1.0, 1.0);
  const Direction middle = geo::directionFromDegrees(46.5, 7.5);
  std::erase_if(places, [&](const Direction& p) { return geo::angleBetween(p, middle).degrees() < 0.1; });
  const PointGround ground = groundOf(places);
  const auto heights = heightsAt(ground, {middle, geo::directionFromDegrees(46.2, 7.2),
                                          geo::directionFromDegrees(47.2, 7.5), geo::directionFromDegrees(-46.5, 7.5)});
  EXPECT_TRUE(isNoData(heights[0]));
  EXPECT_FALSE(isNoData(heights[1]));
  EXPECT_TRUE(isNoData(heights[2]));
  EXPECT_TRUE(isNoData(heights[3]));
}

TEST(PointGround, OfADenseSurveyInASparseOneHasNoHoles) {
  auto random = geo::seededGenerator();
  for (const int dense : {2000, 30000}) {
    std::vector<Direction> places = spread(random, 3000, 46.0, 7.0, 2.0, 2.0);
    std::ranges::copy(spread(random, dense, 46.7, 7.7, 0.3, 0.3), std::back_inserter(places));
    const PointGround ground = groundOf(places);
    const auto asked = spread(random, 10000, 46.5, 7.5, 0.7, 0.7);
    const auto heights = heightsAt(ground, asked);
    EXPECT_LE(std::ranges::count_if(heights, isNoData), 0) << dense;
    double worst = 0.0;
    for (std::size_t i = 0; i < asked.size(); ++i)
      worst = std::max(worst, std::abs(static_cast<double>(heights[i]) - hills(asked[i])));
    EXPECT_LT(worst, 300.0) << dense;  // of hills of 1,400 m, points 3 km apart
  }
}

TEST(PointGround, BoundsHoldItAndMayTouchMissesNothing) {
  auto random = geo::seededGenerator();
  const tiling::Tiling tiling(tiling::Scheme::healpix);
  for (const Case& of : cases(random)) {
    const PointGround ground = groundOf(of.places);
    for (const int level : ground.points().spacingLevels()) {
      const geo::GeoRect bounds = ground.bounds(level);
      std::vector<Direction> asked;
      const double reach = 10.0 * ScatteredPoints::spacingOf(level).radians();
      for (int i = 0; i < 500; ++i) {
        const geo::Vec3 aside(geo::uniform(random, -reach, reach), geo::uniform(random, -reach, reach),
                              geo::uniform(random, -reach, reach));
        asked.push_back({geo::normalize(of.places[random() % of.places.size()].n + aside)});
      }
      std::vector<float> heights(asked.size(), kNoData);
      ASSERT_TRUE(ground.sampleHeights(level, asked, heights).has_value());
      for (std::size_t i = 0; i < asked.size(); ++i) {
        if (isNoData(heights[i])) continue;
        const geo::Geodetic at = geo::geodeticFromDirection(asked[i]);
        EXPECT_TRUE(bounds.contains(at.lat, at.lon)) << of.name << " " << at.lat.degrees() << " " << at.lon.degrees();
        EXPECT_TRUE(ground.mayTouch(level, tiling, tiling.tileAt(asked[i], 14), {})) << of.name;
      }
    }
  }
}

TEST(ScatteredPoints, OfOnePlaceAreTheirMean) {
  const Direction place = geo::directionFromDegrees(46.0, 7.0);
  const ScatteredPoints points({packedPoint(place, 10.0F), packedPoint(place, 20.0F), packedPoint(place, 60.0F)});
  ASSERT_EQ(points.size(), 1u);
  EXPECT_FLOAT_EQ(points.point(0).height_m, 30.0F);
  EXPECT_LT(geo::angleBetween(placeOf(points.point(0)), place).radians(), 1e-13);
  EXPECT_TRUE(points.spacingLevels().empty());
}

TEST(ScatteredPoints, AreAsFarApartAsTheirLevelSays) {
  auto random = geo::seededGenerator();
  for (const double side : {0.01, 0.3, 8.0}) {
    const int count = 10000;
    const ScatteredPoints points(packed(spread(random, count, 10.0, 20.0, side, side), hills));
    const double spacing = side / std::sqrt(count) * 0.017453;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points.spacingLevel(i) == ScatteredPoints::kNoLevel) continue;
      const double own = ScatteredPoints::spacingOf(points.spacingLevel(i)).radians();
      EXPECT_GT(own, spacing * 0.25);
      EXPECT_LT(own, spacing * 4.0);
    }
  }
}

TEST(ScatteredPoints, AlongALineMakeNoGroundAndTakeNoRoomWhereTheyCross) {
  std::vector<Direction> line;
  for (int i = 0; i < 20000; ++i)
    line.push_back(geo::directionFromDegrees(10.0 + 1e-4 * i, 20.0 + 0.3e-4 * i));
  EXPECT_TRUE(ScatteredPoints(packed(line, hills)).spacingLevels().empty());
  std::vector<Direction> grid = gridded(10.0, 20.0, 0.05, 40, 40);
  std::ranges::copy(line, std::back_inserter(grid));
  EXPECT_LT(ScatteredPoints(packed(grid, hills)).size(), 6000u);
}

}  // namespace
}  // namespace tellurion::raster
