#include "raster/seam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geo/body.h"
#include "geo/seed_test.h"

namespace tellurion::raster {
namespace {

const geo::Ellipsoid kEarth = geo::earth().ellipsoid;

/// A round model with a round void in it, anywhere, poles and date line too. Where its bounds go round a pole the map
/// is too coarse for the void, and there is none.
struct RoundModel {
  explicit RoundModel(std::mt19937_64& random)
      : lat(geo::uniform(random, -1, 1) > 0.8 ? 90.0 : geo::uniform(random, -85, 85)),
        lon(geo::uniform(random, 170, 190)),
        radius_degrees(geo::uniform(random, 0.01, 4.0)),
        middle(geo::directionFromDegrees(lat, lon)) {}

  double lat;
  double lon;
  double radius_degrees;
  geo::Direction middle;

  geo::GeoRect bounds() const {
    const double south = std::max(lat - radius_degrees, -90.0);
    const double north = std::min(lat + radius_degrees, 90.0);
    const double most = std::max(std::abs(south), std::abs(north));
    if (most + radius_degrees >= 90.0) return geo::GeoRect::fromDegrees(south, -180, north, 180);
    const double half = radius_degrees / std::cos(most * geo::kPi / 180.0);
    return geo::GeoRect::fromDegrees(south, lon - half, north, lon + half);
  }
  /// Metres from the border inwards, negative outside; the void reaches to a tenth of the radius.
  double inside_m(const geo::Direction& d) const {
    const double angle = geo::angleBetween(d, middle).degrees();
    return std::min(radius_degrees - angle, angle - 0.1 * radius_degrees) * geo::kPi / 180.0 * kEarth.semiMajorAxis_m();
  }
};

geo::Direction randomPlace(const RoundModel& model, std::mt19937_64& random) {
  const geo::Vec3 shift(geo::uniform(random, -1, 1), geo::uniform(random, -1, 1), geo::uniform(random, -1, 1));
  return {geo::normalize(model.middle.n + shift * (1.2 * model.radius_degrees * geo::kPi / 180.0))};
}

TEST(Seam, isNothingOutsideAllFarInsideAndSmoothBetween) {
  std::mt19937_64 random = geo::seededGenerator();
  for (int i = 0; i < 12; ++i) {
    const RoundModel model(random);
    const double extent_m = 2.0 * model.radius_degrees * geo::kPi / 180.0 * kEarth.semiMajorAxis_m();
    const double width_m = geo::uniform(random, 0.03, 0.12) * extent_m;
    const auto seam = Seam::around(model.bounds(), kEarth, width_m,
                                   [&](const geo::Direction& d) { return model.inside_m(d) >= 0.0; });
    ASSERT_TRUE(seam) << model.lat;
    ASSERT_EQ(seam->width_m(), width_m);
    // The map of a box in latitude and longitude may be much wider than the model.
    const double cell_m = 4.0 * extent_m / Seam::kMapSide;
    int between = 0;
    for (int k = 0; k < 3000; ++k) {
      const geo::Direction place = randomPlace(model, random);
      const double inside_m = model.inside_m(place);
      const double weight = seam->weight(place);
      EXPECT_TRUE(inside_m > 0.0 || weight < 1e-12) << inside_m;
      EXPECT_TRUE(inside_m < width_m + 3.0 * cell_m || weight == 1.0) << inside_m;
      between += weight > 0.0 && weight < 1.0 ? 1 : 0;
      // No step: a smoothstep rises by 1.5 over its width at most.
      const geo::Direction beside{geo::normalize(place.n + geo::Vec3(1e-9, -2e-9, 1e-9))};
      const double way_m = geo::length(place.n - beside.n) * kEarth.semiMajorAxis_m();
      EXPECT_LE(std::abs(seam->weight(beside) - weight), 2.5 * way_m / width_m + 1e-9);
    }
    EXPECT_GT(between, 20);
  }
}

TEST(Seam, ofAWholePlanetThereIsNone) {
  const auto everywhere = [](const geo::Direction&) { return true; };
  EXPECT_FALSE(Seam::around(geo::GeoRect::whole(), kEarth, 0.0, everywhere));
  EXPECT_FALSE(Seam::around(geo::GeoRect::fromDegrees(-50, 0, 50, 10), kEarth, 0.0, everywhere));
  const auto usual = Seam::around(geo::GeoRect::fromDegrees(27, 86, 28, 87), kEarth, 0.0, everywhere);
  ASSERT_TRUE(usual);
  EXPECT_NEAR(usual->width_m(), 0.05 * 98e3, 200.0);
  EXPECT_EQ(usual->weight(geo::directionFromDegrees(27.5, 86.5)), 1.0);
  EXPECT_EQ(usual->weight(geo::directionFromDegrees(-27.5, -93.5)), 0.0);
}

}  // namespace
}  // namespace tellurion::raster
