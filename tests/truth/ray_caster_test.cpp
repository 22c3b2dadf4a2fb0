#include "truth/ray_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/body.h"
#include "scene/picking.h"

namespace tellurion::truth {
namespace {

constexpr unsigned int kSeed = 20261122;
constexpr int kRays = 1500;
constexpr double kPixelAngle = 1e-3;

/// Height above the raster's ground at a distance along a ray.
double above_m(const SourceSurface& surface, const geo::Ray& ray, double distance_m) {
  const geo::Geodetic at = surface.ellipsoid().geodeticFromBody({ray.origin.m + ray.direction * distance_m});
  return at.height_m - surface.height_m(at.lat.degrees(), at.lon.degrees());
}

/// How deep a ray went below the ground before it was said to meet it, in pixels.
double deepest_px(const SourceSurface& surface, const geo::Ray& ray, double met_m) {
  const double end_m = std::isnan(met_m) ? 400e3 : met_m - 0.5;
  double deepest = 0.0;
  for (double d = 10.0; d < end_m; d += std::max(10.0, d * kPixelAngle / 20.0))
    deepest = std::max(deepest, -above_m(surface, ray, d) / (d * kPixelAngle));
  return deepest;
}

// Eyes 300 m above the Himalaya that look about the horizon: a pixel is far smaller than a sample there.
TEST(RayCaster, StepsOverNoCrestBetweenSamplesWhenItLooksFinely) {
  const SourceSurface surface({TELLURION_SOURCE_DIR "/data/earth/etopo5_dem_10min.tif"}, geo::earth().ellipsoid);
  std::mt19937_64 random(kSeed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  int met = 0;
  int steppedOver = 0;  // by the steps that are fine where a pixel covers a sample
  for (int i = 0; i < kRays; ++i) {
    scene::Camera camera;
    const double lat = uniform(26, 34);
    const double lon = uniform(80, 95);
    camera.position = {.lat = geo::Angle::degrees(lat),
                       .lon = geo::Angle::degrees(lon),
                       .height_m = surface.height_m(lat, lon) + 300.0};
    camera.heading = geo::Angle::degrees(uniform(0, 360));
    camera.pitch = geo::Angle::degrees(uniform(-4, 2));
    const scene::View view = scene::viewOf(camera, surface.ellipsoid(), geo::Angle::degrees(45), {});
    const geo::Ray ray = scene::rayThrough(view, scene::centreOf(view.viewport));
    const double fine_m = distanceFinelyAlong(surface, ray, kPixelAngle);
    const double coarse_m = distanceAlong(surface, ray, kPixelAngle);
    const bool agree = std::isnan(fine_m) ? std::isnan(coarse_m) : std::abs(coarse_m - fine_m) < 0.5;
    steppedOver += agree ? 0 : 1;
    if (!agree || i % 30 == 0) {
      EXPECT_LE(deepest_px(surface, ray, fine_m), 0.1) << "ray " << i << " of seed " << kSeed;
    }
    if (std::isnan(fine_m)) continue;
    EXPECT_NEAR(above_m(surface, ray, fine_m), 0.0, 0.01) << "ray " << i << " of seed " << kSeed;
    ++met;
  }
  EXPECT_GE(met, kRays / 4);
  EXPECT_GE(steppedOver, 1);
}

// Around the border of the model of Everest, which lies over a coarse one. Its samples lie on its border.
TEST(SourceSurface, LeavesOpenOnlyWhereBetweenTwoSamplesARasterEnds) {
  const SourceSurface both({TELLURION_SOURCE_DIR "/data/earth/etopo5_dem_10min.tif",
                            TELLURION_SOURCE_DIR "/data/earth/srtm3_everest_N27E086_filled.tif"},
                           geo::earth().ellipsoid);
  const SourceSurface coarse({TELLURION_SOURCE_DIR "/data/earth/etopo5_dem_10min.tif"}, geo::earth().ellipsoid);
  constexpr double kSample = 1.0 / 1200.0;
  std::mt19937_64 random(kSeed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  int open = 0;
  for (int i = 0; i < 4000; ++i) {
    const double outwards = uniform(-3.0, 3.0);  // samples, from the outermost one's middle
    const double along = uniform(0.1, 0.9);
    const double lat = i % 2 == 0 ? 28.0 + outwards * kSample : 27.0 + along;
    const double lon = i % 2 == 0 ? 86.0 + along : 86.0 - outwards * kSample;
    const auto heights = both.heights(lat, lon);
    const double said_m = both.height_m(lat, lon);
    EXPECT_TRUE(heights.low_m <= said_m && said_m <= heights.high_m) << lat << ", " << lon;
    const double coarse_m = coarse.height_m(lat, lon);
    if (outwards > 0.01 && outwards < 0.99) {
      EXPECT_TRUE(heights.low_m == coarse_m || heights.high_m == coarse_m) << lat << ", " << lon;
      open += heights.low_m < heights.high_m ? 1 : 0;
    } else if (outwards < -0.01 || outwards > 1.01) {
      EXPECT_EQ(heights.low_m, heights.high_m) << lat << ", " << lon;
    }
  }
  EXPECT_GE(open, 600);
}

}  // namespace
}  // namespace tellurion::truth
