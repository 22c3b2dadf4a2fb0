#include "raster/grid_places.h"

#include <gtest/gtest.h>

#include "raster/grid_fixture_test.h"

namespace tellurion::raster {
namespace {

using namespace testing;

TEST(GridPlaces, BetweenTheLatticePlacesAreWithinTheirError) {
  auto random = geo::seededGenerator();
  double worst = 0.0;
  for (GridService service : {lonLatService(12, 256), mercatorService(12, 256), polarService(8, 256)}) {
    service.kind = Kind::imagery;
    const auto geometry = GridGeometry::make(service).value();
    for (const auto scheme : {tiling::Scheme::geographic, tiling::Scheme::cube, tiling::Scheme::healpix}) {
      const tiling::Tiling tiling(scheme);
      for (int i = 0; i < 12; ++i) {
        const int level = i % 8;
        tiling::TileId id = randomTile(random, tiling, level);
        if (i % 3 == 0) id = tiling.tileAt(geo::directionFromDegrees(i % 2 == 0 ? -90.0 : 85.0, 180.0), level);
        const PlanePlaces places = tilePlaces(*geometry, tiling, id, Kind::imagery, kImageryPixels);
        const geo::Angle spacing = sampleSpacing(tiling, level, kImageryPixels);
        PlanePlaces exact;
        forEachPlace(tiling, id, Kind::imagery, kImageryPixels, [&](int column, int row, const geo::Direction& place) {
          if ((column * 7 + row * 13) % 23 != 0) return;
          const auto index = static_cast<std::size_t>(row * (kImageryPixels + 2 * kGutter) + column);
          geometry->places({&place, 1}, exact);
          const GridFit fit = geometry->fit(spacing, scheme, exact.narrowing[0]);
          if (fit.level < 0 || !std::isfinite(exact.x[0])) return;
          const auto& window = geometry->window(fit.level).topology;
          const auto wanted = geometry->pixel(fit.level, exact.x[0], exact.y[0]);
          const auto got = geometry->pixel(fit.level, places.x[index], places.y[index]);
          if (!(wanted.col >= 0 && wanted.col <= window.width && wanted.row >= 0 && wanted.row <= window.height))
            return;
          const double dx = window.ring > 0 ? std::remainder(got.col - wanted.col, window.ring) : got.col - wanted.col;
          worst = std::max({worst, std::abs(dx), std::abs(got.row - wanted.row)});
        });
      }
    }
  }
  EXPECT_LT(worst, kPlaceError_pixels);
  EXPECT_GT(worst, 0.0);
}

TEST(GridPlaces, PixelsKeepTheirFractionsOverWholePixels) {
  auto random = geo::seededGenerator();
  const auto geometry = GridGeometry::make(lonLatService(18, 256)).value();
  for (int i = 0; i < 10000; ++i) {
    const auto p = geometry->pixel(17, geo::uniform(random, -180.0, 180.0), geo::uniform(random, -90.0, 90.0));
    const double whole = std::floor(geo::uniform(random, -1e9, 1e9));
    EXPECT_EQ((p.col + whole) - whole, p.col);
    EXPECT_EQ((p.row + whole) - whole, p.row);
  }
}

}  // namespace
}  // namespace tellurion::raster
