#include "raster/raster_places.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raster/grid_fixture_test.h"

namespace tellurion::raster {
namespace {

using namespace testing;

/// A whole body in pixels of a fifteenth of a degree, and a part of it that is turned.
Placement wholeMap() {
  Georeference reference;
  reference.transform = {-180.0, 1.0 / 15.0, 0.0, 90.0, 0.0, -1.0 / 15.0};
  reference.turn = 360.0;
  return {std::move(reference), 5400, 2700};
}
Placement turnedMap() {
  Georeference reference;
  reference.transform = {10.0, 0.03, 0.01, 50.0, 0.01, -0.03};
  reference.turn = 360.0;
  return {std::move(reference), 2000, 1500};
}

TEST(RasterPlaces, OfATileAreWithinTheirError) {
  auto random = geo::seededGenerator();
  double worst = 0.0;
  double worstSide = 0.0;
  const std::array placements{wholeMap(), turnedMap()};
  for (const Placement& placement : placements) {
    for (const auto scheme : {tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix}) {
      const tiling::Tiling tiling(scheme);
      for (int i = 0; i < 24; ++i) {
        const int level = i % 8;
        tiling::TileId id = randomTile(random, tiling, level);
        if (i % 4 == 0) id = tiling.tileAt(geo::directionFromDegrees(i % 8 == 0 ? -90.0 : 85.0, 180.0), level);
        if (i % 4 == 1)
          id = tiling.tileAt(
              geo::directionFromDegrees(geo::uniform(random, 25.0, 50.0), geo::uniform(random, 15.0, 60.0)), level);
        const geo::Angle side = i % 3 == 0 ? geo::Angle() : geo::Angle::degrees(0.2);
        const PixelPlaces places = tilePixels(placement, tiling, id, kImageryPixels, side);
        PixelPlaces exact;
        forEachPlace(tiling, id, Kind::imagery, kImageryPixels, [&](int column, int row, const geo::Direction& place) {
          if ((column * 7 + row * 13) % 19 != 0) return;
          const auto index = static_cast<std::size_t>(row * (kImageryPixels + 2 * kGutter) + column);
          placement.squares({&place, 1}, geo::Angle::degrees(0.2), exact);
          const GridTopology& grid = placement.topology();
          const bool isInside =
              exact.col[0] >= 0 && exact.col[0] <= grid.width && exact.row[0] >= 0 && exact.row[0] <= grid.height;
          if (!isInside) return;
          const double dx = places.col[index] - exact.col[0];
          worst = std::max({worst, std::abs(grid.ring > 0 ? std::remainder(dx, grid.ring) : dx),
                            std::abs(places.row[index] - exact.row[0])});
          ASSERT_EQ(places.width.empty(), side == geo::Angle());
          if (side == geo::Angle()) return;
          worstSide = std::max({worstSide, std::abs(places.width[index] / exact.width[0] - 1.0),
                                std::abs(places.height[index] / exact.height[0] - 1.0)});
        });
      }
    }
  }
  EXPECT_LT(worst, kRasterPlaceError_pixels);
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worstSide, 0.02);
}

TEST(RasterPlaces, GuttersAreExact) {
  const Placement placement = wholeMap();
  const tiling::Tiling tiling(tiling::Scheme::healpix);
  const tiling::TileId id = tiling.tileAt(geo::directionFromDegrees(61.0, 179.9), 3);
  const PixelPlaces places = tilePixels(placement, tiling, id, kImageryPixels, {});
  constexpr int kLast = kImageryPixels + 2 * kGutter - 1;
  PixelPlaces exact;
  forEachPlace(tiling, id, Kind::imagery, kImageryPixels, [&](int column, int row, const geo::Direction& place) {
    if (column != 0 && row != 0 && column != kLast && row != kLast) return;
    placement.pixels({&place, 1}, exact);
    const auto index = static_cast<std::size_t>(row * (kLast + 1) + column);
    EXPECT_EQ(places.col[index], exact.col[0]);
    EXPECT_EQ(places.row[index], exact.row[0]);
  });
}

}  // namespace
}  // namespace tellurion::raster
