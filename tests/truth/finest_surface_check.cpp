#include "truth/finest_surface_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pyramid/height_query.h"
#include "scene/picking.h"

namespace tellurion::truth {

void expectSound(const FinestSurface& ground, const std::shared_ptr<const raster::TileSource>& database,
                 RandomCameras cameras) {
  auto query = pyramid::HeightQuery::create(database);
  ASSERT_TRUE(query);
  const auto height = [&](const geo::Direction& d) { return ground.height_m(d); };
  int same = 0;
  constexpr int kPlaces = 100;
  for (int i = 0; i < kPlaces; ++i) {
    const scene::View view = cameras.anywhere(height);
    const geo::Direction below = ground.ellipsoid().directionFromBody(view.eye);
    const auto answer = query->at(below);
    ASSERT_TRUE(answer && *answer);
    same += std::abs((*answer)->height_m - ground.height_m(below)) < 0.01 ? 1 : 0;

    const geo::Ray ray = scene::rayThrough(view, scene::centreOf(view.viewport));
    const double distance_m = ground.distanceAlong(ray);
    const double end_m = std::isnan(distance_m) ? 10.0 * ground.ellipsoid().semiMajorAxis_m() : distance_m;
    const auto above_m = [&](double d) {
      const geo::BodyPosition p{ray.origin.m + ray.direction * d};
      return ground.ellipsoid().geodeticFromBody(p).height_m - height(ground.ellipsoid().directionFromBody(p));
    };
    if (!std::isnan(distance_m)) {
      // Rays may graze a crest: what a thousandth of a pixel is across, there.
      const double exact_m = 1e-5 * distance_m;
      const double slack_m = std::max(0.01, 1e-6 * distance_m);
      EXPECT_GT(above_m(distance_m - exact_m), -slack_m) << "ray " << i;
      // And a ray may leave it again soon; on a cliff millimetres decide.
      double lowest_m = above_m(distance_m);
      for (int k = 1; k <= 400; ++k)
        lowest_m = std::min(lowest_m, above_m(distance_m + k * 5e-9 * (1.0 + distance_m)));
      EXPECT_LT(lowest_m, slack_m) << "ray " << i;
    }
    for (double share = 0.01; share < 0.999; share += 0.01)
      EXPECT_GT(above_m(share * end_m), 0.0) << "ray " << i << ", " << share << " of " << end_m << " m";
  }
  EXPECT_GE(same, kPlaces - 3);
}

}  // namespace tellurion::truth
