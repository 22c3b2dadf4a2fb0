// What is left out of the sky's dome: nothing that a picture shows, and no row that it could tell apart.

#include "render/sky_part.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geo/body.h"
#include "render/synthetic_tiles_test.h"
#include "scene/atmosphere.h"
#include "scene/picking.h"

namespace tellurion::render {
namespace {

using air_shading::kSkyBands;
using air_shading::kSkyColumns;

/// Beyond the horizon, where the table of the air has its rows: the cube root of the tangent of half the angle.
double rowOf(double past_rad, const air_shading::AirView& air) {
  return 1.0 + std::cbrt(std::tan(past_rad / 2.0) * static_cast<double>(air.horizon.w)) * (kSkyBands - 1);
}

TEST(SkyPart, HoldsAllSkyInThePictureAndRowsHalfAPixelApart) {
  std::mt19937 random(7);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const geo::Ellipsoid ellipsoid = geo::earth().ellipsoid;
  const scene::Atmosphere atmosphere = *scene::atmosphereByName("earth");
  const geo::Vec3 scale = airFromBody(ellipsoid);
  int skies = 0;
  int bandsLeftOut = 0;
  int columnsLeftOut = 0;
  for (int n = 0; n < 300; ++n) {
    const double height_m = std::pow(10.0, between(0.4, 8.0));
    const scene::View view =
        synthetic::viewAt(ellipsoid, between(-90, 90), between(-180, 180), height_m, between(0, 360), between(-90, 90),
                          {between(0.0, 1.0) < 0.5 ? 640 : 200, 300}, between(2, 120));
    const geo::Vec3 toSun = geo::directionFromDegrees(between(-90, 90), between(-180, 180)).n;
    const EyeInAir eye = eyeInAir(ellipsoid, view.eye, toSun);
    const air_shading::AirView air = airViewOf(atmosphere, ellipsoid, eye);
    const SkyPart part = skyPartOf(view, air);
    ASSERT_LE(part.bandCount, kSkyBands);
    const geo::Vec3 side(geo::Vec4(air.side));
    const geo::Vec3 across = geo::cross(eye.up, side);
    const double horizon = std::atan2(static_cast<double>(air.horizon.x), static_cast<double>(air.horizon.y));
    for (int k = 0; k < 200; ++k) {
      const geo::Ray ray = scene::rayThrough(view, {between(0, view.viewport.width), between(0, view.viewport.height)});
      const geo::Vec3 direction = geo::normalize(ray.direction * scale);
      const double past = std::acos(std::clamp(-geo::dot(direction, eye.up), -1.0, 1.0)) - horizon;
      if (past < 0.0) continue;
      const double row = rowOf(past, air);
      if (row > kSkyBands) continue;  // past the air
      ++skies;
      ASSERT_GT(part.bandCount, 0) << height_m;
      EXPECT_GE(row, part.rows[0]);
      EXPECT_LE(row, part.rows[static_cast<std::size_t>(part.bandCount)]);
      const double turn =
          std::atan2(geo::dot(direction, across), geo::dot(direction, side)) / (2.0 * geo::kPi) * kSkyColumns;
      const double beyondFirst = std::fmod(turn - part.firstColumn + 2 * kSkyColumns, kSkyColumns);
      EXPECT_TRUE(beyondFirst <= part.columnCount || beyondFirst > kSkyColumns - 1e-6) << beyondFirst;
    }
    for (int b = 0; b < part.bandCount; ++b) {
      const int from = part.rows[static_cast<std::size_t>(b)];
      const int to = part.rows[static_cast<std::size_t>(b) + 1];
      ASSERT_GT(to, from);
      const auto angle = [&](int row) {
        return 2.0 * std::atan(std::pow((row - 1.0) / (kSkyBands - 1), 3.0) / static_cast<double>(air.horizon.w));
      };
      EXPECT_TRUE(to == from + 1 || angle(to) - angle(from) <= 0.5 * view.pixelAngle()) << from << " to " << to;
    }
    bandsLeftOut += part.bandCount < kSkyBands ? 1 : 0;
    columnsLeftOut += part.columnCount < kSkyColumns ? 1 : 0;
  }
  EXPECT_GT(skies, 5000);
  EXPECT_GT(bandsLeftOut, 100);
  EXPECT_GT(columnsLeftOut, 30);
}

}  // namespace
}  // namespace tellurion::render
