#include <gtest/gtest.h>

#include "tiling/places_test.h"

namespace tellurion::tiling {
namespace {

constexpr int kSteps = 8;

TEST_P(EveryTiling, BoundsHoldTheTile) {
  for (int i = 0; i < 20000; ++i) {
    const TileId id = anyTile();
    const geo::GeoRect bounds = tiling_.bounds(id);
    ASSERT_LE(bounds.width, geo::Angle::degrees(360.0));
    ASSERT_GE(bounds.south, geo::Angle::degrees(-90.0));
    ASSERT_LE(bounds.north, geo::Angle::degrees(90.0));
    ASSERT_GE(bounds.west, geo::Angle::degrees(-180.0));
    ASSERT_LT(bounds.west, geo::Angle::degrees(180.0));
    for (int r = 0; r <= kSteps; ++r) {
      for (int c = 0; c <= kSteps; ++c) {
        const geo::Direction d = tiling_.direction(rootPointIn(id, c / double{kSteps}, r / double{kSteps}));
        const geo::Geodetic g = geo::geodeticFromDirection(d);
        ASSERT_TRUE(bounds.contains(g.lat, g.lon)) << toText(id) << " " << g.lat.degrees() << " " << g.lon.degrees();
      }
    }
  }
}

bool holdsPole(const geo::GeoRect& r) {
  return r.north >= geo::Angle::degrees(90.0) || r.south <= geo::Angle::degrees(-90.0);
}

TEST_P(EveryTiling, BoundsAreTightWhereNoPoleIsInside) {
  constexpr double kTight_rad = 1e-9 * geo::kPi / 180.0;
  for (int i = 0; i < 20000; ++i) {
    const TileId id = anyTile();
    const geo::GeoRect bounds = tiling_.bounds(id);
    if (holdsPole(bounds)) continue;
    geo::Angle south = geo::Angle::degrees(90.0);
    geo::Angle north = geo::Angle::degrees(-90.0);
    double west = 10.0;
    double east = -10.0;
    for (int r = 0; r <= kSteps; ++r) {
      for (int c = 0; c <= kSteps; ++c) {
        const geo::Geodetic g =
            geo::geodeticFromDirection(tiling_.direction(rootPointIn(id, c / double{kSteps}, r / double{kSteps})));
        const double offset = std::remainder((g.lon - bounds.west - bounds.width / 2.0).radians(), 2.0 * geo::kPi);
        south = std::min(south, g.lat);
        north = std::max(north, g.lat);
        west = std::min(west, offset);
        east = std::max(east, offset);
      }
    }
    ASSERT_NEAR(south.radians(), bounds.south.radians(), kTight_rad) << toText(id);
    ASSERT_NEAR(north.radians(), bounds.north.radians(), kTight_rad) << toText(id);
    ASSERT_NEAR(east - west, bounds.width.radians(), 2.0 * kTight_rad) << toText(id);
  }
}

TEST_P(EveryTiling, BoundsOfTheRootsCoverThePoles) {
  bool north = false;
  bool south = false;
  for (const TileId& id : allTiles(tiling_, 0)) {
    north = north || tiling_.bounds(id).contains(geo::Angle::degrees(90.0), geo::Angle::degrees(33.0));
    south = south || tiling_.bounds(id).contains(geo::Angle::degrees(-90.0), geo::Angle::degrees(33.0));
  }
  EXPECT_TRUE(north && south);
}

TEST(GeographicTiling, BoundsAboutThePole) {
  const Tiling tiling(Scheme::geographic);
  const auto expect = [&](const TileId& id, double south, double north, double west, double width) {
    const geo::GeoRect r = tiling.bounds(id);
    EXPECT_NEAR(r.south.degrees(), south, 1e-11) << toText(id);
    EXPECT_NEAR(r.north.degrees(), north, 1e-11) << toText(id);
    EXPECT_NEAR(std::remainder(r.west.degrees() - west, 360.0), 0.0, 1e-11) << toText(id);
    EXPECT_NEAR(r.width.degrees(), width, 1e-11) << toText(id);
  };
  expect({0, 4, 0, 0}, 45.0, 90.0, -180.0, 360.0);   // the pole inside
  expect({1, 4, 1, 1}, 45.0, 90.0, 0.0, 90.0);       // at a corner
  expect({1, 5, 0, 1}, -90.0, -45.0, -180.0, 90.0);  // of the other cap
  // On a diagonal: the border's longitudes are linear, and the northern corner has the diagonal's.
  const double north = geo::geodeticFromDirection(tiling.direction({4, 0.75, 0.75})).lat.degrees();
  expect({2, 4, 3, 3}, 45.0, north, 22.5, 45.0);
}

TEST_P(EveryTiling, CapsHoldTheTile) {
  const auto check = [this](const TileId& id, int steps) {
    const Cap cap = tiling_.cap(id);
    for (int k = 0; k <= steps; ++k) {
      for (const Edge edge : kEdges) {
        const geo::Direction d = tiling_.direction(onEdge(id, edge, k / static_cast<double>(steps)));
        ASSERT_LE(geo::angleBetween(cap.centre, d), cap.radius) << toText(id);
      }
    }
    const geo::Direction inside =
        tiling_.direction(rootPointIn(id, geo::uniform(random_, 0.0, 1.0), geo::uniform(random_, 0.0, 1.0)));
    ASSERT_LE(geo::angleBetween(cap.centre, inside), cap.radius) << toText(id);
  };
  for (int level = 0; level <= 5; ++level) {
    for (const TileId& id : allTiles(tiling_, level))
      check(id, 64);
  }
  for (int i = 0; i < 50000; ++i)
    check(anyTile(), 8);
}

TEST_P(EveryTiling, CapsAreNoLargerThanTheTile) {
  for (int i = 0; i < 20000; ++i) {
    const TileId id = anyTile();
    const double diagonal = std::sqrt(2.0) * tiling_.metrics(id.level).largestEdge.radians();
    ASSERT_LE(tiling_.cap(id).radius.radians(), diagonal + 1e-14) << toText(id);
  }
}

}  // namespace
}  // namespace tellurion::tiling
